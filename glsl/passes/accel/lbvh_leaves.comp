#version 430
// The corners of the triangles in leaf order, so that a leaf is read in one run: (x, y, z, -), the first with the
// triangle's number instead of -, and SOLID if it is not cloth (material 0).
#include "trace/shared.glsl"
layout(local_size_x = 64) in;
#include "inputs/gpu/item.glsl"
uniform usamplerBuffer corners;
uniform usamplerBuffer leaf_triangles;
uniform usamplerBuffer attributes;
layout(std430) writeonly buffer LeafCorners { uvec4 leaf_corner[]; };
uniform int leaf_ref_count;

void main() {
    int i = item();
    if (i >= leaf_ref_count) return;
    uint triangle = texelFetch(leaf_triangles, i).x;
    uint tag = triangle | (texelFetch(attributes, int(triangle)).x != 0u ? SOLID : 0u);
    leaf_corner[3 * i] = uvec4(texelFetch(corners, int(3u * triangle)).xyz, tag);
    leaf_corner[3 * i + 1] = uvec4(texelFetch(corners, int(3u * triangle) + 1).xyz, 0u);
    leaf_corner[3 * i + 2] = uvec4(texelFetch(corners, int(3u * triangle) + 2).xyz, 0u);
}
