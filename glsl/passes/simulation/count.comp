#version 430
// Contact, step 1: count the vertices in each bucket of the hash. One invocation per vertex.
#include "simulate/contact.glsl"
layout(local_size_x = 64) in;
#include "inputs/gpu/item.glsl"
layout(std430) readonly buffer Position { vec4 x[]; };
layout(std430) buffer Count { int bucket_count[]; };
uniform int vertex_count;
uniform int table_size;
uniform float cell_size;

void main() {
    int index = item();
    if (index < vertex_count) {
        atomicAdd(bucket_count[bucket(floor(x[index].xyz / cell_size), table_size)], 1);
    }
}
