#version 430
// Contact, step 5: list for each vertex the vertices within one cell size that are not its own neighbours in the weave.
// The lists serve several substeps. OTHER: vertices of another cloth instead. One invocation per vertex.
#include "simulate/shared.glsl"
#include "simulate/contact.glsl"
layout(local_size_x = 64) in;
#include "inputs/gpu/item.glsl"
layout(std430) readonly buffer Position { vec4 x[]; };
#ifdef OTHER
layout(std430) readonly buffer OtherPosition { vec4 other_x[]; };
#else
#define other_x x
#endif
layout(std430) readonly buffer Begin { int begin[]; };
layout(std430) readonly buffer Cursor { int cursor[]; };
layout(std430) readonly buffer Member { int member[]; };
layout(std430) writeonly buffer Near { int near[]; };       // MAX_NEAR slots per vertex
layout(std430) writeonly buffer NearCount { int near_count[]; };
layout(std430) buffer Overflow { int overflow; };           // the longest list asked for, if too long
uniform int vertex_count;
uniform int columns;
uniform int table_size;
uniform float cell_size;
uniform vec2 spacing;        // m of the flat cloth, along a row and down a column
uniform float apart;         // m: vertices nearer than that in the flat cloth are one layer

void main() {
    int index = item();
    if (index >= vertex_count) {
        return;
    }
    vec3 here = x[index].xyz;
    vec3 home = floor(here / cell_size);
    int i = index / columns;
    int j = index - i * columns;
    int found = 0;
    for (int k = 0; k < 27; k++) {
        vec3 cell = home + vec3(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1);
        int slot = bucket(cell, table_size);
        for (int m = begin[slot]; m < cursor[slot]; m++) {
            int other = member[m];
            vec3 there = other_x[other].xyz;
            vec3 e = there - here;
#ifdef OTHER
            const bool woven = false;
#else
            int other_i = other / columns;
            ivec2 off = ivec2(other - other_i * columns - j, other_i - i);
            vec2 flat_off = vec2(off) * spacing;
            bool woven = abs(off.x) <= 1 && abs(off.y) <= 1 || dot(flat_off, flat_off) < apart * apart;
#endif
            // Another cell may share the bucket: its vertices are met in their own cell, or are too far.
            if (!woven && dot(e, e) < cell_size * cell_size && floor(there / cell_size) == cell) {
                if (found < MAX_NEAR) {
                    near[index * MAX_NEAR + found] = other;
                }
                found++;
            }
        }
    }
    near_count[index] = min(found, MAX_NEAR);
    if (found > MAX_NEAR) {
        atomicMax(overflow, found);
    }
}
