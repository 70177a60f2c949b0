#version 430
// Contact of one cloth with another in one substep: the sum of what parts each vertex from the other's, and how many they are;
// passes/simulation/contact.comp takes the mean. Both cloths are as they were before either moves. One invocation per vertex.
#include "simulate/shared.glsl"
#include "simulate/contact.glsl"
layout(local_size_x = 64) in;
#include "inputs/gpu/item.glsl"
uniform samplerBuffer Position;
uniform samplerBuffer Previous;
uniform samplerBuffer OtherPosition;
uniform samplerBuffer OtherPrevious;
uniform isamplerBuffer Near;        // vertices of the other cloth
uniform isamplerBuffer NearCount;
layout(std430) buffer Met { vec4 met[]; };  // sum, how many
uniform int vertex_count;
uniform bool begins;  // with no other cloth yet
uniform float gap;    // m
uniform float mu;

void main() {
    int index = item();
    if (index >= vertex_count) {
        return;
    }
    vec4 here = texelFetch(Position, index);
    vec3 moved = here.xyz - texelFetch(Previous, index).xyz;
    vec4 sum = begins ? vec4(0.0) : met[index];
    int count = texelFetch(NearCount, index).x;
    for (int k = 0; k < count; k++) {
        int other = texelFetch(Near, index * MAX_NEAR + k).x;
        vec4 there = texelFetch(OtherPosition, other);
        vec3 e = here.xyz - there.xyz;
        if (dot(e, e) < gap * gap) {
            vec3 slide = moved - (there.xyz - texelFetch(OtherPrevious, other).xyz);
            sum += vec4(part(here.xyz, there.xyz, here.w, there.w, gap, slide, mu), 1.0);
        }
    }
    met[index] = sum;
}
