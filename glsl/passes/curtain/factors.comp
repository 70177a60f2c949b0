#version 430
// Form factors from receivers to polygons: exact, times what of the polygon is visible from the receiver past the room, by
// four rays. Cloth hides nothing here. Of the rays that see the polygon it is counted how many cross the curtain, for each of four
// leans of it, and where; what it lets through is multiplied where light is summed.
#include "trace/form_factor.glsl"
#include "inputs/accel/ray.glsl"
#include "inputs/accel/visit_any.glsl"
#include "accel.glsl"
layout(local_size_x = 64) in;
#include "inputs/gpu/item.glsl"
uniform samplerBuffer receivers;  // (position, 1: of the curtain) (normal, -)
uniform samplerBuffer senders;    // four corners, counter-clockwise from the front; (.., 1: of the curtain)
layout(std430) writeonly buffer Factors { float factors[]; };
layout(std430) writeonly buffer Crossings { uint crossings[]; };  // rays that see it, those that cross at each lean: 3 bits each; the column
uniform int receiver_count;
uniform int first;         // of the senders
uniform int sender_count;  // from there on
uniform float offset;      // how far off a surface rays begin and end
// The curtain as a sheet, which leans by so many metres a metre below the rail.
uniform vec4 panels;       // from where to where its pieces hang on the rail, x; one piece has twice the same
uniform vec2 height;       // y of its hem and of the rail
uniform float sheet_z;     // at the rail
uniform float flare;       // each side is as much further out a metre below it
uniform float depth;       // its folds reach as far to either side
uniform vec4 leans;
uniform int lean_of_sheet; // which of these senders that are cells of the curtain have
uniform float columns[COLUMNS + 1];  // borders of its cells on the rail, x

const vec2 POINTS[4] = vec2[4](vec2(0.125, 0.375), vec2(0.375, 0.875), vec2(0.625, 0.125), vec2(0.875, 0.625));

// How far a place lies before the leaning sheet, and beyond a side of a piece.
float before(vec3 p, float lean) { return p.z - sheet_z - lean * (height.y - p.y); }

float beyond(vec3 p, vec2 piece, float side) {
    return side * (p.x - 0.5 * (piece.x + piece.y)) - 0.5 * (piece.y - piece.x) - flare * (height.y - p.y);
}

bool hangs_at(vec3 p) { return p.y > height.x && p.y < height.y; }

// Whether the way from a to b meets the outermost folds at the sides of a piece, which close the gap to the wall.
bool meets_side(vec3 a, vec3 b, vec2 piece, float lean) {
    bool met = false;
    for (int k = 0; k < 2; ++k) {
        float side = k == 0 ? -1.0 : 1.0;
        float g_a = beyond(a, piece, side), g_b = beyond(b, piece, side);
        vec3 p = mix(a, b, g_a != g_b ? g_a / (g_a - g_b) : 0.0);
        met = met || (g_a * g_b < 0.0 && hangs_at(p) && abs(before(p, lean)) < depth);
    }
    return met;
}

// Whether it goes through the sheet; p: where.
bool goes_through(vec3 a, vec3 b, float lean, out vec3 p) {
    float f_a = before(a, lean), f_b = before(b, lean);
    p = mix(a, b, f_a != f_b ? f_a / (f_a - f_b) : 0.0);
    bool on = max(beyond(p, panels.xy, -1.0), beyond(p, panels.xy, 1.0)) < 0.0 || max(beyond(p, panels.zw, -1.0), beyond(p, panels.zw, 1.0)) < 0.0;
    return f_a * f_b < 0.0 && hangs_at(p) && on;
}

bool meets_sides(vec3 a, vec3 b, float lean) { return meets_side(a, b, panels.xy, lean) || meets_side(a, b, panels.zw, lean); }

int column_of(vec3 p) {
    float middle = 0.5 * (columns[0] + columns[COLUMNS]), reach = 0.5 * (columns[COLUMNS] - columns[0]);
    float x = middle + (p.x - middle) * reach / (reach + flare * max(height.y - p.y, 0.0));
    int k = 0;
    for (int i = 1; i < COLUMNS; ++i) k += x > columns[i] ? 1 : 0;
    return k;
}

void main() {
    int i = item();
    if (i >= receiver_count * sender_count) return;
    int r = i % receiver_count;
    int s = first + i / receiver_count;
    vec4 x = texelFetch(receivers, 2 * r);
    vec3 n = texelFetch(receivers, 2 * r + 1).xyz;
    vec4 a = texelFetch(senders, 4 * s);
    vec3 b = texelFetch(senders, 4 * s + 1).xyz;
    vec3 c = texelFetch(senders, 4 * s + 2).xyz;
    vec3 d = texelFetch(senders, 4 * s + 3).xyz;
    vec3 front = normalize(cross(b - a.xyz, d - a.xyz));
    vec3 middle = c == d ? (a.xyz + b + c) / 3.0 : 0.25 * (a.xyz + b + c + d);
    bool on_sheet = x.w > 0.5;
    bool of_sheet = a.w > 0.5;
    // The curtain's sides see what lies before them; fold to fold is `folds`'s.
    bool meets = dot(x.xyz - middle, front) > 1e-6 && !(on_sheet && (of_sheet || before(middle, 0.0) * n.z <= 0.0));
    uint seen_by = 0u;
    uvec4 crossing = uvec4(0u);
    uint column = 0u;
    float F = meets ? quad_factor(a.xyz - x.xyz, b - x.xyz, c - x.xyz, d - x.xyz, n) : 0.0;
    if (F > 1e-5) {
        int k = 0;
        do {
            vec2 u = POINTS[k];
            vec3 p = mix(mix(a.xyz, b, u.x), mix(d, c, u.x), u.y) + offset * front;
            vec3 o = x.xyz + offset * n;
            float way = length(p - o);
            vec3 toward = (p - o) / max(way, 1e-12);
            Visit visit = Visit(way, NO_TRIANGLE, vec2(0.0));
            traverse(make_ray(o, toward, 0.0, way), visit);
            bool sees = visit.triangle == NO_TRIANGLE;
            // Cells of the curtain that are seen past its sides only are not.
            if (of_sheet) sees = sees && !meets_sides(o, p, leans[lean_of_sheet]);
            seen_by += sees ? 1u : 0u;
            if (sees && !on_sheet && !of_sheet) {
                for (int l = 0; l < 4; ++l) {
                    vec3 at;
                    bool through = goes_through(o, p, leans[l], at);
                    if (through && column == 0u) column = uint(column_of(at));
                    crossing[l] += through || meets_sides(o, p, leans[l]) ? 1u : 0u;
                }
            }
            ++k;
        } while (k < 4);
        F *= 0.25 * float(seen_by);
    } else {
        F = 0.0;
    }
    int out_at = (first + i / receiver_count) * receiver_count + r;
    factors[out_at] = F;
    crossings[out_at] = seen_by | crossing.x << 3 | crossing.y << 6 | crossing.z << 9 | crossing.w << 12 | column << 15;
}
