#version 430
// Runs the method that is included as "method.glsl" on given directions, in the surface frame.
#include "method.glsl"

layout(local_size_x = 64) in;
#include "inputs/gpu/item.glsl"
layout(std430) readonly buffer Directions { vec4 omega_o[]; };
layout(std430) buffer Results { vec4 result[]; };
uniform int first;
uniform int count;

void main() {
    int i = first + item();
    if (i >= count) return;
    vec3 o = omega_o[i].xyz;
    if (o.z > 0.0) result[i] += vec4(L_o(o, mat3(1.0)), 1.0);
}
