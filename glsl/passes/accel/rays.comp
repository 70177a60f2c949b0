#version 430
// Traces rays through the structure that is included as "accel.glsl" with the visitor "visit.glsl" (closest or any).
// A ray is two texels: (origin, t_min) (direction, t_max). A hit is one: (t, triangle, v, w).
// `resume` continues from the hits of an earlier dispatch. "range.glsl" says which rays.
#include "inputs/accel/ray.glsl"
#include "visit.glsl"
#include "accel.glsl"
layout(local_size_x = 64) in;
#include "inputs/gpu/item.glsl"
#include "range.glsl"
uniform samplerBuffer rays;
layout(std430) buffer Hits { uvec4 hits[]; };
uniform int resume;

void main() {
    int i = item();
    if (i >= ray_count) return;
    i += first_ray;
    vec4 o = texelFetch(rays, 2 * i);
    vec4 d = texelFetch(rays, 2 * i + 1);
    Visit visit = Visit(d.w, NO_TRIANGLE, vec2(0.0));
    if (resume != 0) {
        uvec4 before = hits[i];
        visit = Visit(uintBitsToFloat(before.x), before.y, uintBitsToFloat(before.zw));
    }
    Ray ray = make_ray(o.xyz, d.xyz, o.w, d.w);
    traverse(ray, visit);
    hits[i] = uvec4(floatBitsToUint(visit.t), visit.triangle, floatBitsToUint(visit.weights));
    count_store(i);
}
