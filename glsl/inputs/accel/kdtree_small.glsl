// The counters of a build, and the lists of small nodes, level by level.
layout(std430) buffer Counters { uint counter[]; };
uniform uint column_nodes;   // of the work groups along y that one along x stands for

// A place for `nodes` more in the list of a level; the columns of work groups that they begin are counted.
uint next_small(int level, uint nodes) {
    uint first = atomicAdd(counter[SMALL_ACTIVE + level], nodes);
    uint begun = (first + nodes + column_nodes - 1u) / column_nodes - (first + column_nodes - 1u) / column_nodes;
    if (begun > 0u) atomicAdd(counter[SMALL_GROUPS + 3 * level], begun);
    return first;
}
