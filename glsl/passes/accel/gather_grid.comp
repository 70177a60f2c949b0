#version 430
// Two triangles for each quad of a grid of vertices, into the triangle soup from triangle `first` on.
// Corners: position and packed normal; attributes: material and the packed x axes (yarn 1) of the three corners.
#include "trace/octahedron.glsl"
layout(local_size_x = 64) in;
#include "inputs/gpu/item.glsl"
layout(std430) readonly buffer Positions { vec4 position[]; };
layout(std430) readonly buffer Normals { vec4 normal[]; };
layout(std430) readonly buffer Tangents { vec4 tangent[]; };
layout(std430) writeonly buffer Corners { uvec4 corner[]; };
layout(std430) writeonly buffer Attributes { uvec4 attributes[]; };
uniform int rows;
uniform int columns;
uniform int first;
uniform int material;

void main() {
    int quad = item();
    if (quad >= (rows - 1) * (columns - 1)) return;
    int a = quad / (columns - 1) * columns + quad % (columns - 1);
    int vertex[4] = int[4](a, a + 1, a + columns, a + columns + 1);
    uvec4 c[4];
    uint x[4];
    for (int k = 0; k < 4; ++k) {
        c[k] = uvec4(floatBitsToUint(position[vertex[k]].xyz), packSnorm2x16(octahedral(normal[vertex[k]].xyz)));
        x[k] = packSnorm2x16(octahedral(tangent[vertex[k]].xyz));
    }
    int t = first + 2 * quad;
    corner[3 * t] = c[0];
    corner[3 * t + 1] = c[2];
    corner[3 * t + 2] = c[1];
    corner[3 * t + 3] = c[1];
    corner[3 * t + 4] = c[2];
    corner[3 * t + 5] = c[3];
    attributes[t] = uvec4(material, x[0], x[2], x[1]);
    attributes[t + 1] = uvec4(material, x[1], x[2], x[3]);
}
