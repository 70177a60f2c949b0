#version 430
// After a level of large nodes: how many the next one has, how many invocations share each, and the work groups of its
// passes, so that the CPU need not wait for the numbers. After the last level those of the roots of small nodes.
#include "trace/shared.glsl"
layout(local_size_x = 8) in;
#include "inputs/accel/kdtree_counters.glsl"
uniform int level;           // the next one
uniform int lanes_of_all;    // invocations that share a level,
uniform int fewest_lanes;    // and a node
uniform int most_lanes;
uniform int lane_refs;       // the most references that a lane can count
uniform int lane_capacity;

void main() {
    if (gl_GlobalInvocationID.x != 0u) return;
    uint nodes = counter[ACTIVE_COUNT];
    counter[GENERATIONS + level + 1] = counter[NODE_COUNT];
    int doublings = nodes > 1u ? findMSB(nodes - 1u) + 1 : 0;
    int fewest = max(fewest_lanes, (int(counter[ACTIVE_MOST]) + lane_refs - 1) / lane_refs);
    int lanes = max(min(lanes_of_all >> min(doublings, 31), most_lanes), fewest);
    if (nodes * uint(lanes) > uint(lane_capacity)) counter[NEED_LANES] = nodes * uint(lanes);
    bool stop = stopped();
    if (stop) nodes = 0u;
    if (nodes > 0u) counter[LARGE_USED] = uint(level) + 1u;
    counter[ACTIVE_NOW] = nodes;
    counter[LANES_NOW] = uint(lanes);
    counter[ACTIVE_COUNT] = 0u;
    counter[ACTIVE_MOST] = 0u;
    counter[NEXT_REF_COUNT] = 0u;
    set_groups(LANE_GROUPS, groups_of(nodes * uint(lanes)));
    set_groups(NODE_GROUPS, groups_of(nodes));
    // Roots wait until no large node is left.
    set_groups(MASK_GROUPS, stop || nodes > 0u ? 0u : counter[ROOT_COUNT]);
}
