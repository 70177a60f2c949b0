#version 430
// Large nodes, second of three passes a level, one invocation a node: cut off empty space, or split where it costs least;
// make the children.   [Zhou 2008, section 3.1; Mat 4.3.2]
//
// A node is four texels: (low, split) (high, axis) (first child, kind, depth, first lane) (first reference, count, -, -).
// Each node is split once a level, so several empty sides are cut off level by level. The node's last word keeps for the
// third pass how: bit 0: all references go left, bit 1: all go right.
// References lie in one buffer in three runs of `ref_capacity`: this level's, the next one's, and those of small nodes.
#include "trace/shared.glsl"
#include "trace/split.glsl"
layout(local_size_x = 64) in;
#include "inputs/gpu/item.glsl"
uniform usamplerBuffer nodes;
uniform usamplerBuffer active_nodes;
uniform usamplerBuffer lane_data;
layout(std430) writeonly buffer Nodes { uvec4 node[]; };
layout(std430) buffer Counters { uint counter[]; };
layout(std430) writeonly buffer Active { uint next_active[]; };
layout(std430) writeonly buffer Roots { uvec4 root[]; };
uniform bool spatial_median;  // instead of the plane of least cost
uniform float margin;        // of empty space round the references that is not cut off: of points, whose boxes have no extent
uniform int level;
uniform int small_size;      // a node of at most so many references is small
uniform int node_capacity;
uniform int ref_capacity;
uniform int next_base;       // where the references of the next level begin
uniform int small_base;      // where the references of small nodes begin

// Room for the references of a small root, or of a large node that stays a leaf; where it begins, or NO_TRIANGLE.
uint reserve_small(uint self, uint count, bool large_leaf) {
    uint at = atomicAdd(counter[SMALL_REF_COUNT], count);
    if (at + count > uint(ref_capacity)) {
        atomicMax(counter[NEED_REFS], at + count);
        return NO_TRIANGLE;
    }
    at += uint(small_base);
    root[atomicAdd(counter[ROOT_COUNT], 1u)] = uvec4(self, at, count, large_leaf ? 1u : 0u);
    return at;
}

// Room for the references of a large child; where it begins, or NO_TRIANGLE.
uint reserve_next(uint self, uint count) {
    uint at = atomicAdd(counter[NEXT_REF_COUNT], count);
    if (at + count > uint(ref_capacity)) {
        atomicMax(counter[NEED_REFS], at + count);
        return NO_TRIANGLE;
    }
    next_active[atomicAdd(counter[ACTIVE_COUNT], 1u)] = self;
    atomicMax(counter[ACTIVE_MOST], count);
    return at + uint(next_base);
}

void make_child(uint self, vec3 low, vec3 high, uint count) {
    uint kind = PENDING;
    uint at = 0u;
    if (count == 0u) {
        kind = EMPTY_LEAF;
    } else if (count <= uint(small_size)) {
        at = reserve_small(self, count, false);
    } else {
        at = reserve_next(self, count);
    }
    // A child without room stays empty; the host sees the counter and builds again.
    if (at == NO_TRIANGLE) kind = EMPTY_LEAF;
    node[4u * self] = uvec4(floatBitsToUint(low), 0u);
    node[4u * self + 1u] = uvec4(floatBitsToUint(high), 0u);
    node[4u * self + 2u] = uvec4(0u, kind, uint(level + 1), 0u);
    node[4u * self + 3u] = uvec4(at, kind == EMPTY_LEAF ? 0u : count, 0u, 0u);
}

void main() {
    int index = item();
    if (index >= int(counter[ACTIVE_NOW])) return;
    int lanes = int(counter[LANES_NOW]);
    int self = int(texelFetch(active_nodes, index).x);
    uvec2 range = texelFetch(nodes, 4 * self + 3).xy;
    vec3 cell_low = uintBitsToFloat(texelFetch(nodes, 4 * self).xyz);
    vec3 cell_high = uintBitsToFloat(texelFetch(nodes, 4 * self + 1).xyz);
    vec3 low = vec3(3e38);
    vec3 high = vec3(-3e38);
    int begin = LANE_TEXELS * lanes * index;
    int end = begin + LANE_TEXELS * lanes;
    for (int i = begin; i < end; i += LANE_TEXELS) {
        low = min(low, uintBitsToFloat(texelFetch(lane_data, i).xyz));
        high = max(high, uintBitsToFloat(texelFetch(lane_data, i + 1).xyz));
    }
    float best = 3e38;
    vec4 plane = vec4(0.0);
    uvec2 count = uvec2(0u);
    uint column = 0u;
    for (int k = 0; k < LARGE_PLANES; ++k) {
        uvec3 left = uvec3(0u);
        uvec3 right = uvec3(0u);
        for (int i = begin + 2 + k; i < end; i += LANE_TEXELS) {
            uvec3 counts = texelFetch(lane_data, i).xyz;
            left += counts & 0xffffu;
            right += counts >> 16u;
        }
        float fraction = plane_fraction(k, LARGE_PLANES);
        vec3 cost = plane_costs(cell_low, cell_high, fraction, vec3(left), vec3(right));
        // Paper B and Zhou et al. 2008 cut a large node in the middle of its longest side.
        if (spatial_median) cost = k == LARGE_PLANES / 2 ? cell_low - cell_high : vec3(3e38);
        vec3 n = least_axis(cost);
        if (dot(n, cost) < best) {
            best = dot(n, cost);
            plane = vec4(n, dot(n, planes_at(cell_low, cell_high, fraction)));
            count = uvec2(n.x > 0.0 ? left.x : n.y > 0.0 ? left.y : left.z, n.x > 0.0 ? right.x : n.y > 0.0 ? right.y : right.z);
            column = uint(2 + k);
        }
    }
    vec4 gap = gap_plane(cell_low, cell_high, low - margin, high + margin, EMPTY_SHARE);
    uint all_sides = 0u;
    if (gap.xyz != vec3(0.0)) {
        bool all_left = gap.x + gap.y + gap.z < 0.0;
        plane = vec4(abs(gap.xyz), gap.w);
        all_sides = all_left ? 1u : 2u;
        count = all_left ? uvec2(range.y, 0u) : uvec2(0u, range.y);
    }
    bool inside = plane.w > dot(cell_low, plane.xyz) && plane.w < dot(cell_high, plane.xyz);
    bool stop = !inside || level >= LARGE_LEVELS || float(count.x + count.y) > GROWTH_LIMIT * float(range.y);
    uint children = 0u;
    if (!stop) {
        children = atomicAdd(counter[NODE_COUNT], 2u);
        if (children + 2u > uint(node_capacity)) {
            atomicMax(counter[NEED_NODES], children + 2u);
            stop = true;
        }
    }
    node[4 * self] = uvec4(floatBitsToUint(cell_low), floatBitsToUint(plane.w));
    node[4 * self + 1] = uvec4(floatBitsToUint(cell_high), uint(dot(plane.xyz, vec3(0.0, 1.0, 2.0))));
    node[4 * self + 2] = uvec4(children, stop ? LARGE_LEAF : INNER, uint(level), column);
    if (stop) {
        atomicMax(counter[LONGEST_LEAF_COUNT], range.y);
        uint at = reserve_small(uint(self), range.y, true);
        // Where the references are (x, y), and where they go (z).
        node[4 * self + 3] = uvec4(range.x, at == NO_TRIANGLE ? 0u : range.y, at, 0u);
    } else {
        node[4 * self + 3] = uvec4(range, 0u, all_sides);
        make_child(children, cell_low, mix(cell_high, vec3(plane.w), plane.xyz), count.x);
        make_child(children + 1u, mix(cell_low, vec3(plane.w), plane.xyz), cell_high, count.y);
    }
}
