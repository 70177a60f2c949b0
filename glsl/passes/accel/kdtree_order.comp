#version 430
// The place of each node in preorder, and of its first triangle in the leaves' order, by one work group: sizes of
// subtrees from the leaves up, then places from the root down.   [Zhou 2008, section 3.3]
// The place does not depend on the order in which atomic operations numbered the nodes.
// Children lie in a later generation than their parent. Where the tree is not complete, nothing is done.
#include "trace/shared.glsl"
layout(local_size_x = 256) in;
#include "inputs/accel/kdtree_counters.glsl"
uniform usamplerBuffer nodes;
layout(std430) coherent buffer Sizes { uvec2 size[]; };      // nodes, triangles of the subtree
layout(std430) writeonly buffer TreeBox { uvec4 box[]; };      // of the root
layout(std430) coherent buffer Places { uvec2 place[]; };   // node, first triangle
uniform int large_levels;    // that were dispatched
uniform int small_levels;
uniform int leaf_capacity;

shared uint bounds[MOST_GENERATIONS];  // the first nodes of the generations, and the end

void main() {
    if (stopped() || counter[ACTIVE_NOW] > 0u || counter[SMALL_ACTIVE + small_levels] > 0u) return;
    int generation_count = large_levels + small_levels;
    if (gl_LocalInvocationID.x == 0u) {
        for (int g = 0; g <= large_levels + 1; ++g) bounds[g] = counter[GENERATIONS + g];
        for (int g = 1; g < small_levels; ++g) bounds[large_levels + 1 + g] = bounds[large_levels + g] + counter[SMALL_ACTIVE + g];
    }
    barrier();
    for (int g = generation_count - 1; g >= 0; --g) {
        int end = int(bounds[g + 1]);
        for (int i = int(bounds[g]) + int(gl_LocalInvocationID.x); i < end; i += 256) {
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
        uint leaf_refs = size[0].y;
        counter[LEAF_REF_COUNT] = leaf_refs;
        uvec3 low = texelFetch(nodes, 0).xyz;
        uvec3 high = texelFetch(nodes, 1).xyz;
        box[0] = uvec4(low, 0u);
        box[1] = uvec4(high, 0u);
        for (int axis = 0; axis < 3; ++axis) {
            counter[ROOT_BOX + axis] = low[axis];
            counter[ROOT_BOX + 3 + axis] = high[axis];
        }
        bool fits = leaf_refs <= uint(leaf_capacity);
        if (!fits) counter[NEED_LEAF_REFS] = leaf_refs;
        set_groups(EMIT_GROUPS, fits ? groups_of(counter[NODE_COUNT]) : 0u);
        set_groups(LEAF_GROUPS, fits ? groups_of(leaf_refs) : 0u);
    }
    memoryBarrierBuffer();
    barrier();
    for (int g = 0; g < generation_count; ++g) {
        int end = int(bounds[g + 1]);
        for (int i = int(bounds[g]) + int(gl_LocalInvocationID.x); i < end; i += 256) {
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
