#version 430
// Traces rays through the structure that is included as "accel.glsl" with the visitor "visit.glsl" (closest or any).
// A ray is two texels: (origin, t_min) (direction, t_max). A hit is one: (t, triangle, v, w).
// Rays lie in two runs: [0, front_count) and from back_first on; `resume` continues from the hits of an earlier dispatch.
#include "inputs/accel/ray.glsl"
#include "visit.glsl"
#include "accel.glsl"
layout(local_size_x = 64) in;
layout(binding = 11) uniform samplerBuffer rays;
layout(std430, binding = 0) buffer Hits { uvec4 hits[]; };
uniform int ray_count;
uniform int front_count;
uniform int back_first;
uniform int resume;

void main() {
    int i = int(gl_GlobalInvocationID.x);
    if (i >= ray_count) return;
    if (i >= front_count) i += back_first - front_count;
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
