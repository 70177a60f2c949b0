#version 430
// Acceleration of every vertex by the air: a third of the force on each triangle round it. One invocation per vertex.
layout(local_size_x = 64) in;
#include "inputs/gpu/item.glsl"
uniform samplerBuffer Position;
layout(std430) writeonly buffer Air { vec4 air[]; };     // m/s^2
uniform samplerBuffer AirForce;   // N, two triangles per quad
uniform int rows;
uniform int columns;

// Triangles of a quad as glcloth.geometry.shapes.grid_triangles cuts it: even quads along a-d, odd ones along b-c.
//   a b    even: (a, c, d) (a, d, b)    odd: (a, c, b) (b, c, d)
//   c d
vec3 share(int i, int j, vec2 even, vec2 odd) {
    if (i < 0 || j < 0 || i >= rows - 1 || j >= columns - 1) {
        return vec3(0.0);
    }
    int quad = 2 * (i * (columns - 1) + j);
    vec2 part = ((i + j) & 1) == 0 ? even : odd;
    return part.x * texelFetch(AirForce, quad).xyz + part.y * texelFetch(AirForce, quad + 1).xyz;
}

void main() {
    int index = item();
    if (index >= rows * columns) {
        return;
    }
    int i = index / columns;
    int j = index - i * columns;
    vec3 force = share(i, j, vec2(1.0), vec2(1.0, 0.0))               // as corner a
               + share(i, j - 1, vec2(0.0, 1.0), vec2(1.0))           // b
               + share(i - 1, j, vec2(1.0, 0.0), vec2(1.0))           // c
               + share(i - 1, j - 1, vec2(1.0), vec2(0.0, 1.0));      // d
    air[index] = vec4(force * (texelFetch(Position, index).w / 3.0), 0.0);
}
