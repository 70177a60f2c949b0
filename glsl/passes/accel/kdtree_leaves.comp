#version 430
// The corners of the pairs in leaf order, so that a leaf is read in one run. Triangles (a, c, b) and (b, c, d) are four texels
// (x, y, z, -); with a and b lie their numbers, and SOLID if they are not cloth (material 0). A triangle without a partner has
// d = b, which nothing hits, and NO_TRIANGLE for the partner's number.
#include "trace/shared.glsl"
layout(local_size_x = 64) in;
#include "inputs/gpu/item.glsl"
uniform usamplerBuffer corners;
uniform usamplerBuffer leaf_pairs;
uniform usamplerBuffer attributes;
layout(std430) writeonly buffer LeafCorners { uvec4 leaf_corner[]; };
layout(std430) readonly buffer Counters { uint counter[]; };

void main() {
    int i = item();
    if (i >= int(counter[LEAF_REF_COUNT])) return;
    uint pair = texelFetch(leaf_pairs, i).x;
    uint triangle = pair >> 1;
    bool two = (pair & 1u) != 0u;
    int first = int(3u * triangle);
    uint solid = texelFetch(attributes, int(triangle)).x != 0u ? SOLID : 0u;
    uvec3 b = texelFetch(corners, first + 2).xyz;
    leaf_corner[4 * i] = uvec4(texelFetch(corners, first).xyz, triangle | solid);
    leaf_corner[4 * i + 1] = uvec4(b, two ? triangle + 1u | solid : NO_TRIANGLE);
    leaf_corner[4 * i + 2] = uvec4(texelFetch(corners, first + 1).xyz, 0u);
    leaf_corner[4 * i + 3] = uvec4(two ? texelFetch(corners, first + 5).xyz : b, 0u);
}
