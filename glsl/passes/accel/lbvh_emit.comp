#version 430
// The nodes as the tracer reads them, four texels each: (low, child) (high, -) of the left child, then of the right.
// A child is a node's number, or 0x80000000 | first triangle << 3 | count: subtrees of few triangles become leaves.
#include "trace/shared.glsl"
layout(local_size_x = 64) in;
#include "inputs/gpu/item.glsl"
uniform usamplerBuffer keys;
uniform usamplerBuffer tree;
uniform usamplerBuffer boxes;
#ifdef PIECES
uniform usamplerBuffer pieces;
#endif
layout(std430) writeonly buffer BvhNodes { uvec4 bvh_node[]; };
layout(std430) writeonly buffer LeafTriangles { uint leaf_triangle[]; };
uniform int key_count;

void main() {
    int i = item();
    if (i >= key_count) return;
    uint key = texelFetch(keys, i).y;
#ifdef PIECES
    key = texelFetch(pieces, int(key)).x;
#endif
    leaf_triangle[i] = key;
    if (i == key_count - 1) return;
    uvec4 node = texelFetch(tree, i);
    for (int k = 0; k < 2; ++k) {
        uint child = k == 0 ? node.x : node.y;
        uint at = child;
        if ((child & 0x80000000u) != 0u) {
            uint key = child & 0x7fffffffu;
            at = uint(key_count - 1) + key;
            child = 0x80000000u | key << 3 | 1u;
        } else {
            uvec2 range = texelFetch(tree, int(child)).zw;
            uint count = range.y - range.x + 1u;
            if (count <= uint(BVH_LEAF)) child = 0x80000000u | range.x << 3 | count;
        }
        bvh_node[4 * i + 2 * k] = uvec4(texelFetch(boxes, int(2u * at)).xyz, child);
        bvh_node[4 * i + 2 * k + 1] = uvec4(texelFetch(boxes, int(2u * at) + 1).xyz, 0u);
    }
}
