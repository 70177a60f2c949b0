#version 430
// Form factors from receivers to polygons: exact, times what of the polygon is visible from the receiver past the room, by
// four rays. Cloth hides nothing here; a pair whose line crosses the curtain gets a negative factor instead, and what the
// curtain lets through is multiplied where light is summed.
#include "trace/form_factor.glsl"
#include "inputs/accel/ray.glsl"
#include "inputs/accel/visit_any.glsl"
#include "accel.glsl"
layout(local_size_x = 64) in;
#include "inputs/gpu/item.glsl"
uniform samplerBuffer receivers;  // (position, 1: of the curtain) (normal, -)
uniform samplerBuffer senders;    // four corners, counter-clockwise from the front; (.., 1: of the curtain)
layout(std430) writeonly buffer Factors { vec2 factors[]; };  // all of it, and what crosses the curtain
uniform int receiver_count;
uniform int first;         // of the senders
uniform int sender_count;  // from there on
uniform float offset;      // how far off a surface rays begin and end
uniform samplerBuffer nodes;  // of the curtain as a sheet: corners of its cells, row by row from below
uniform ivec2 cells;

const vec2 POINTS[4] = vec2[4](vec2(0.125, 0.375), vec2(0.375, 0.875), vec2(0.625, 0.125), vec2(0.875, 0.625));

vec3 node(ivec2 i) { return texelFetch(nodes, i.y * (cells.x + 1) + i.x).xyz; }

// Where on the sheet a place is seen along z, in cells (beyond its rim: from -1 to 1 cell more), and its z there.
vec3 on_sheet_at(vec2 p) {
    float y_0 = node(ivec2(0)).y, y_1 = node(ivec2(0, cells.y)).y;
    float v = clamp((p.y - y_0) / (y_1 - y_0) * float(cells.y), -1.0, float(cells.y) + 1.0);
    int j = clamp(int(floor(v)), 0, cells.y - 1);
    float g = clamp(v - float(j), 0.0, 1.0);
    int i = 0;
    vec3 left = mix(node(ivec2(0, j)), node(ivec2(0, j + 1)), g), right = mix(node(ivec2(1, j)), node(ivec2(1, j + 1)), g);
    while (i < cells.x - 1 && p.x > right.x) {
        ++i;
        left = right;
        right = mix(node(ivec2(i + 1, j)), node(ivec2(i + 1, j + 1)), g);
    }
    float f = (p.x - left.x) / (right.x - left.x);
    return vec3(float(i) + f, v, mix(left.z, right.z, clamp(f, 0.0, 1.0)));
}

float before_sheet(vec3 p) { return p.z - on_sheet_at(p.xy).z; }

// Whether the way from a to b goes through the sheet.
bool crosses_sheet(vec3 a, vec3 b) {
    float f_a = before_sheet(a), f_b = before_sheet(b);
    if (f_a * f_b >= 0.0) return false;
    float low = 0.0, high = 1.0, t = 0.5;
    for (int k = 0; k < 4; ++k) {
        t = low + (high - low) * clamp(f_a / (f_a - f_b), 0.05, 0.95);
        float f = before_sheet(mix(a, b, t));
        if (f * f_a > 0.0) {
            low = t;
            f_a = f;
        } else {
            high = t;
            f_b = f;
        }
    }
    vec2 at = on_sheet_at(mix(a, b, t).xy).xy;
    return at.x > 0.0 && at.x < float(cells.x) && at.y > 0.0 && at.y < float(cells.y);
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
    bool meets = dot(x.xyz - middle, front) > 1e-6 && !(on_sheet && (of_sheet || before_sheet(middle) * n.z <= 0.0));
    float crossing = 0.0;
    float F = meets ? quad_factor(a.xyz - x.xyz, b - x.xyz, c - x.xyz, d - x.xyz, n) : 0.0;
    if (F > 1e-5) {
        float seen = 0.0;
        int k = 0;
        do {
            vec2 u = POINTS[k];
            vec3 p = mix(mix(a.xyz, b, u.x), mix(d, c, u.x), u.y) + offset * front;
            vec3 o = x.xyz + offset * n;
            float way = length(p - o);
            vec3 toward = (p - o) / max(way, 1e-12);
            Visit visit = Visit(way, NO_TRIANGLE, vec2(0.0));
            traverse(make_ray(o, toward, 0.0, way), visit);
            float whole = visit.triangle == NO_TRIANGLE ? 0.25 : 0.0;
            seen += whole;
            crossing += !on_sheet && !of_sheet && whole > 0.0 && crosses_sheet(o, p) ? whole : 0.0;
            ++k;
        } while (k < 4);
        crossing /= max(seen, 0.25);
        F *= seen;
    } else {
        F = 0.0;
    }
    factors[(first + i / receiver_count) * receiver_count + r] = vec2(F, F * crossing);
}
