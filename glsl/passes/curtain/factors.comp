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
layout(std430) writeonly buffer Factors { float factors[]; };
uniform int receiver_count;
uniform int first;         // of the senders
uniform int sender_count;  // from there on
uniform float offset;      // how far off a surface rays begin and end
uniform vec4 sheet;        // of the curtain: the least x and y, the largest
uniform float sheet_z;

const vec2 POINTS[4] = vec2[4](vec2(0.125, 0.375), vec2(0.375, 0.875), vec2(0.625, 0.125), vec2(0.875, 0.625));

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
    bool meets = dot(x.xyz - middle, front) > 1e-6 && !(on_sheet && (of_sheet || (middle.z - sheet_z) * n.z <= 0.0));
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
            seen += visit.triangle == NO_TRIANGLE ? 0.25 : 0.0;
            ++k;
        } while (k < 4);
        F *= seen;
    } else {
        F = 0.0;
    }
    float z = middle.z - x.z;
    float t = z != 0.0 ? (sheet_z - x.z) / z : -1.0;
    vec2 at = x.xy + t * (middle.xy - x.xy);
    bool crosses = !on_sheet && !of_sheet && t > 0.0 && t < 1.0
                   && all(greaterThan(at, sheet.xy)) && all(lessThan(at, sheet.zw));
    factors[(first + i / receiver_count) * receiver_count + r] = crosses ? -F : F;
}
