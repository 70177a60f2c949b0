#version 430
// Contact of the cloth with itself in one substep: how far each vertex should move, the mean over its contacts (a sum
// would push too far where several vertices of one layer meet it). Read by simulate_finish. One invocation per vertex.
#include "simulate/shared.glsl"
#include "simulate/contact.glsl"
layout(local_size_x = 64) in;
layout(std430, binding = 0) readonly buffer Position { vec4 x[]; };
layout(std430, binding = 1) readonly buffer Previous { vec4 p[]; };
layout(std430, binding = 2) writeonly buffer Contact { vec4 shift[]; };
layout(std430, binding = 3) readonly buffer Near { int near[]; };
layout(std430, binding = 4) readonly buffer NearCount { int near_count[]; };
uniform int vertex_count;
uniform float gap;   // m
uniform float mu;

void main() {
    int index = int(gl_GlobalInvocationID.x);
    if (index >= vertex_count) {
        return;
    }
    vec4 here = x[index];
    vec3 moved = here.xyz - p[index].xyz;
    vec3 sum = vec3(0.0);
    float contacts = 0.0;
    int count = near_count[index];
    for (int k = 0; k < count; k++) {
        int other = near[index * MAX_NEAR + k];
        vec4 there = x[other];
        vec3 e = here.xyz - there.xyz;
        if (dot(e, e) < gap * gap) {
            vec3 slide = moved - (there.xyz - p[other].xyz);
            sum += part(here.xyz, there.xyz, here.w, there.w, gap, slide, mu);
            contacts += 1.0;
        }
    }
    shift[index] = vec4(contacts > 0.0 ? sum / contacts : vec3(0.0), 0.0);
}
