#version 430
// Writes the nodes in preorder, as the tracer reads them, and the pairs of triangles of the leaves.
//   inner: (split, axis | right child << 2), the left child is the next node
//   leaf:  (first pair in leaf order, 3 | count << 2)
#include "trace/shared.glsl"
layout(local_size_x = 64) in;
#include "inputs/gpu/item.glsl"
uniform usamplerBuffer refs;
uniform usamplerBuffer nodes;
uniform usamplerBuffer places;
layout(std430) writeonly buffer TreeNodes { uvec2 tree_node[]; };
layout(std430) writeonly buffer LeafPairs { uint leaf_pair[]; };
layout(std430) readonly buffer Counters { uint counter[]; };

void main() {
    int i = item();
    if (i >= int(counter[NODE_COUNT])) return;
    uvec4 head = texelFetch(nodes, 4 * i + 2);
    uvec2 place = texelFetch(places, i).xy;
    if (head.y == INNER) {
        uint axis = texelFetch(nodes, 4 * i + 1).w;
        uint right = texelFetch(places, int(head.x) + 1).x;
        tree_node[place.x] = uvec2(texelFetch(nodes, 4 * i).w, axis | right << 2);
        return;
    }
    uvec4 set = texelFetch(nodes, 4 * i + 3);
    uint count = 0u;
    if (head.y == LARGE_LEAF) {
        count = set.y;
        for (uint k = 0u; k < count; ++k) leaf_pair[place.y + k] = texelFetch(refs, int(2u * (set.z + k))).w;
    } else if (head.y == SMALL_LEAF || head.y == PENDING) {
        for (int word = 0; word < 2; ++word) {
            uint rest = set[word];
            while (rest != 0u) {
                int r = int(set.z) + 32 * word + findLSB(rest);
                leaf_pair[place.y + count++] = texelFetch(refs, 2 * r).w;
                rest &= rest - 1u;
            }
        }
    }
    tree_node[place.x] = uvec2(place.y, 3u | count << 2);
}
