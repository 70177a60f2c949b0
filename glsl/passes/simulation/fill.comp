#version 430
// Contact, step 3: put each vertex into its bucket; afterwards cursor is the bucket's end. One invocation per vertex.
#include "simulate/contact.glsl"
layout(local_size_x = 64) in;
#include "inputs/gpu/item.glsl"
layout(std430) readonly buffer Position { vec4 x[]; };
layout(std430) buffer Cursor { int cursor[]; };
layout(std430) writeonly buffer Member { int member[]; };
uniform int vertex_count;
uniform int table_size;
uniform float cell_size;

void main() {
    int index = item();
    if (index < vertex_count) {
        member[atomicAdd(cursor[bucket(floor(x[index].xyz / cell_size), table_size)], 1)] = index;
    }
}
