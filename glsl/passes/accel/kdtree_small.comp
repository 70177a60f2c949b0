#version 430
// One level of small nodes, one invocation a node: the candidate of least SAH cost, or a leaf.
// [Zhou 2008, section 3.2; Mat 6, erratum E11]
//   cost = step_cost + (N_left A_left + N_right A_right) / A; a leaf costs its number of triangles.
#include "trace/shared.glsl"
layout(local_size_x = 64) in;
#include "inputs/gpu/item.glsl"
#include "inputs/accel/kdtree_small.glsl"
uniform usamplerBuffer nodes;
uniform usamplerBuffer active_nodes;
uniform usamplerBuffer refs;
uniform usamplerBuffer masks;
layout(std430) writeonly buffer Nodes { uvec4 node[]; };
layout(std430) writeonly buffer Active { uint next_active[]; };
uniform int level;
uniform float step_cost;     // of a step, in tests of a reference
uniform int node_capacity;
uniform int small_base;      // where the references of small nodes begin; masks are counted from there

void main() {
    int index = item();
    if (index >= int(counter[SMALL_ACTIVE + level])) return;
    int self = int(texelFetch(active_nodes, index).x);
    vec3 low = uintBitsToFloat(texelFetch(nodes, 4 * self).xyz);
    vec3 high = uintBitsToFloat(texelFetch(nodes, 4 * self + 1).xyz);
    uvec4 set = texelFetch(nodes, 4 * self + 3);
    uint first = set.z;
    vec3 e = high - low;
    float area = e.x * e.y + e.y * e.z + e.z * e.x;
    vec3 face = e.yzx * e.zxy;
    vec3 rim = e.yzx + e.zxy;

    float best = float(bitCount(set.x) + bitCount(set.y)) * area;
    int best_candidate = -1;
    float split = 0.0;
    uvec2 rest = level < SMALL_LEVELS ? set.xy : uvec2(0u);
    while ((rest.x | rest.y) != 0u) {
        uint i;
        if (rest.x != 0u) {
            i = uint(findLSB(rest.x));
            rest.x &= rest.x - 1u;
        } else {
            i = 32u + uint(findLSB(rest.y));
            rest.y &= rest.y - 1u;
        }
        int r = int(first + i);
        int m = 6 * (r - small_base);
        vec3 ref_low = uintBitsToFloat(texelFetch(refs, 2 * r).xyz);
        vec3 ref_high = uintBitsToFloat(texelFetch(refs, 2 * r + 1).xyz);
        for (int c = 0; c < 6; ++c) {
            int axis = c < 3 ? c : c - 3;
            float plane = c < 3 ? ref_low[axis] : ref_high[axis];
            // Strictly inside: then each plane serves once on a path, and the splitting ends.
            if (plane > low[axis] && plane < high[axis]) {
                ivec4 bits = bitCount(texelFetch(masks, m + c) & set.xyxy);
                float cost = step_cost * area + float(bits.x + bits.y) * (face[axis] + rim[axis] * (plane - low[axis]))
                             + float(bits.z + bits.w) * (face[axis] + rim[axis] * (high[axis] - plane));
                if (cost < best) {
                    best = cost;
                    best_candidate = m + c;
                    split = plane;
                }
            }
        }
    }

    uint depth = texelFetch(nodes, 4 * self + 2).z;
    uint children = 0u;
    if (best_candidate >= 0) {
        children = atomicAdd(counter[NODE_COUNT], 2u);
        if (children + 2u > uint(node_capacity)) {
            atomicMax(counter[NEED_NODES], children + 2u);
            best_candidate = -1;
        }
    }
    if (best_candidate < 0) {
        node[4 * self + 2] = uvec4(0u, (set.x | set.y) == 0u ? EMPTY_LEAF : SMALL_LEAF, depth, 0u);
        return;
    }
    int axis = best_candidate % 6;
    axis = axis < 3 ? axis : axis - 3;
    uvec4 sets = texelFetch(masks, best_candidate) & set.xyxy;
    vec3 left_high = high;
    vec3 right_low = low;
    left_high[axis] = split;
    right_low[axis] = split;
    node[4 * self] = uvec4(floatBitsToUint(low), floatBitsToUint(split));
    node[4 * self + 1] = uvec4(floatBitsToUint(high), uint(axis));
    node[4 * self + 2] = uvec4(children, INNER, depth, 0u);
    uint at = 4u * children;
    node[at] = uvec4(floatBitsToUint(low), 0u);
    node[at + 1u] = uvec4(floatBitsToUint(left_high), 0u);
    node[at + 2u] = uvec4(0u, PENDING, depth + 1u, 0u);
    node[at + 3u] = uvec4(sets.xy, first, 0u);
    node[at + 4u] = uvec4(floatBitsToUint(right_low), 0u);
    node[at + 5u] = uvec4(floatBitsToUint(high), 0u);
    node[at + 6u] = uvec4(0u, PENDING, depth + 1u, 0u);
    node[at + 7u] = uvec4(sets.zw, first, 0u);
    uint slot = next_small(level + 1, 2u);
    next_active[slot] = children;
    next_active[slot + 1u] = children + 1u;
}
