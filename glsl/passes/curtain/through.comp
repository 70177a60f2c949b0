#version 430
// Attenuates light between points and the lamp, or along given ways, by the cloth on them; all else blocks. As
// passes/tracing/shadow.comp, rays run from the lamp to the point.
#include "inputs/accel/ray.glsl"
#include "inputs/tracing/visit_attenuate.glsl"
#include "accel.glsl"
layout(local_size_x = 64) in;
#include "inputs/gpu/item.glsl"
uniform samplerBuffer points;
uniform samplerBuffer ends;                    // where `to_lamp` is false: the other ends of the ways
uniform samplerBuffer arriving;                // light before; read in another buffer than it is written to
layout(std430) buffer Lights { vec4 lights[]; };
uniform int point_count;
uniform bool to_lamp;
uniform bool first_chunk;
uniform vec3 lamp;         // its position
uniform float beyond;      // further than this from a point of the scene there is nothing
uniform float offset;      // nearer than this to the lamp nothing counts

void main() {
    int i = item();
    if (i >= point_count) return;
    vec3 p = texelFetch(points, i).xyz;
    vec3 toward = (to_lamp ? lamp : texelFetch(ends, i).xyz) - p;
    float way = length(toward);
    vec3 d = toward / max(way, 1e-12);
    float reach = min(way - offset, beyond);
    Visit visit = start_visit(reach);
    Ray ray = make_ray(p + reach * d, -d, 0.0, reach);
    traverse(ray, visit);
    vec3 before = first_chunk ? texelFetch(arriving, i).rgb : lights[i].rgb;
    lights[i] = vec4(before * reckon(visit, ray), 0.0);
    count_store(i);
}
