#version 430
// How far forward (+z) a cloth hangs over each cell of a plane, and over the eight cells around it: so that what lies between its
// vertices is covered too. One invocation per vertex; a largest value does not depend on the order in which it is found.
layout(local_size_x = 64) in;
#include "inputs/gpu/item.glsl"
uniform samplerBuffer Position;
layout(std430) buffer Heights { uint height[]; };  // the bits of floats that are not negative
uniform int vertex_count;
uniform vec2 backdrop_low;
uniform float backdrop_cell;
uniform ivec2 backdrop_cells;

void main() {
    int i = item();
    if (i >= vertex_count) return;
    vec3 p = texelFetch(Position, i).xyz;
    uint bits = floatBitsToUint(max(p.z, 0.0));
    ivec2 at = ivec2(floor((p.xy - backdrop_low) / backdrop_cell));
    for (int n = 0; n < 9; ++n) {
        ivec2 cell = at + ivec2(n % 3 - 1, n / 3 - 1);
        bool inside = all(greaterThanEqual(cell, ivec2(0))) && all(lessThan(cell, backdrop_cells));
        if (inside) atomicMax(height[cell.y * backdrop_cells.x + cell.x], bits);
    }
}
