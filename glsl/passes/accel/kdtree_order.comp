#version 430
// The place of each node in preorder, and of its first triangle in the leaves' order, by one work group: sizes of
// subtrees from the leaves up, then places from the root down.   [Zhou 2008, section 3.3]
// The place does not depend on the order in which atomic operations numbered the nodes.
// `bounds` are the first nodes of the generations (children lie in a later generation than their parent), and the end.
#include "trace/shared.glsl"
layout(local_size_x = 256) in;
uniform usamplerBuffer nodes;
uniform usamplerBuffer bounds;
layout(std430) writeonly buffer Counters { uint counter[]; };
layout(std430) coherent buffer Sizes { uvec2 size[]; };      // nodes, triangles of the subtree
layout(std430) coherent buffer Places { uvec2 place[]; };   // node, first triangle
uniform int generation_count;

void main() {
    for (int g = generation_count - 1; g >= 0; --g) {
        int end = int(texelFetch(bounds, g + 1).x);
        for (int i = int(texelFetch(bounds, g).x) + int(gl_LocalInvocationID.x); i < end; i += 256) {
            uvec2 head = texelFetch(nodes, 4 * i + 2).xy;
            uvec2 total = uvec2(1u, 0u);
            if (head.y == INNER) {
                total += size[head.x] + size[head.x + 1u];
            } else if (head.y == SMALL_LEAF || head.y == PENDING) {
                uvec2 set = texelFetch(nodes, 4 * i + 3).xy;
                total.y = uint(bitCount(set.x) + bitCount(set.y));
            } else if (head.y == LARGE_LEAF) {
                total.y = texelFetch(nodes, 4 * i + 3).y;
            }
            size[i] = total;
        }
        memoryBarrierBuffer();
        barrier();
    }
    if (gl_LocalInvocationID.x == 0u) {
        place[0] = uvec2(0u);
        counter[LEAF_REF_COUNT] = size[0].y;
    }
    memoryBarrierBuffer();
    barrier();
    for (int g = 0; g < generation_count; ++g) {
        int end = int(texelFetch(bounds, g + 1).x);
        for (int i = int(texelFetch(bounds, g).x) + int(gl_LocalInvocationID.x); i < end; i += 256) {
            uvec2 head = texelFetch(nodes, 4 * i + 2).xy;
            if (head.y == INNER) {
                uvec2 at = place[i] + uvec2(1u, 0u);
                place[head.x] = at;
                place[head.x + 1u] = at + size[head.x];
            }
        }
        memoryBarrierBuffer();
        barrier();
    }
}
