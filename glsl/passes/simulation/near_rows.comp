#version 430
// Lists for each vertex the near vertices of its own row, and of so many rows above and below, that are not its neighbours: for a
// cloth whose rows stay rows (a curtain, whose pleats meet side by side), much cheaper than looking in all directions. One
// invocation per vertex.
#include "simulate/shared.glsl"
layout(local_size_x = 64) in;
#include "inputs/gpu/item.glsl"
uniform samplerBuffer Position;
layout(std430) writeonly buffer Near { int near[]; };       // MAX_NEAR slots per vertex
layout(std430) writeonly buffer NearCount { int near_count[]; };
layout(std430) buffer Overflow { int overflow; };           // the longest list asked for, if too long
uniform int vertex_count;
uniform int columns;
uniform int window;      // columns to look at on either side
uniform int row_window;  // rows to look at on either side
uniform float reach;     // m
uniform int woven;       // so many columns on either side are one layer

void main() {
    int index = item();
    if (index >= vertex_count) {
        return;
    }
    vec3 here = texelFetch(Position, index).xyz;
    int own = index / columns;
    int j = index - own * columns;
    int rows = vertex_count / columns;
    int found = 0;
    for (int i = max(0, own - row_window); i <= min(rows - 1, own + row_window); i++) {
        int row = i * columns;
        for (int k = max(0, j - window); k <= min(columns - 1, j + window); k++) {
            vec3 e = texelFetch(Position, row + k).xyz - here;
            if (abs(k - j) > woven && dot(e, e) < reach * reach) {
                if (found < MAX_NEAR) {
                    near[index * MAX_NEAR + found] = row + k;
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
