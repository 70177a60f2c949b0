// The counters of a build (trace/shared.glsl), and whether it has to stop: a buffer is too small, or a leaf too long to go
// through. Then no more work groups are dispatched, and the host sees why.
layout(std430) buffer Counters { uint counter[]; };
uniform int most_groups;     // that the device takes along one line
uniform int longest_leaf;    // triangles that a leaf may have

bool stopped() {
    uint needs = counter[NEED_NODES] | counter[NEED_REFS] | counter[NEED_LANES];
    return needs != 0u || counter[LONGEST_LEAF_COUNT] > uint(longest_leaf);
}

// Notes the work groups for so many work groups' worth of work, in rows where they are too many for one line.
void set_groups(int at, uint groups) {
    uint rows = max((groups + uint(most_groups) - 1u) / uint(most_groups), 1u);
    counter[at] = (groups + rows - 1u) / rows;
    counter[at + 1] = rows;
    counter[at + 2] = 1u;
}

uint groups_of(uint items) { return (items + uint(NODE_GROUP) - 1u) / uint(NODE_GROUP); }
