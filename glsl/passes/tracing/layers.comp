#version 430
// Casts the heads of straight ways: the layers that each meets, by one traversal ("visit_layers.glsl"), for structures
// that find hits in order. For the others passes/accel/rays.comp finds one layer at a time.
#include "inputs/accel/ray.glsl"
layout(std430) writeonly buffer Layers { uvec2 layer_out[]; };  // (t, triangle, v, w); `stride` a head
#include "inputs/tracing/visit_layers.glsl"
#include "accel.glsl"
layout(local_size_x = 64) in;
#include "inputs/gpu/item.glsl"
#include "inputs/tracing/range_heads.glsl"
uniform samplerBuffer heads;  // (origin, t_min) (direction, t_max)
uniform int stride;

void main() {
    int i = item();
    if (i >= ray_count) return;
    i += first_ray;
    vec4 o = texelFetch(heads, 2 * i);
    vec4 d = texelFetch(heads, 2 * i + 1);
    Visit visit = Visit(d.w, NO_TRIANGLE, o.w, 0, 0, i * stride, d.w);
    Ray ray = make_ray(o.xyz, d.xyz, o.w, d.w);
    traverse(ray, visit);
    // A hit that rounding puts behind the last leaf.
    settle(visit, 3e38);
    if (visit.t_max > 0.0) layer_out[2 * (visit.at + visit.layers)] = uvec2(0u, NO_TRIANGLE);
    count_store(i);
}
