#version 430
// Between two generations of rays: how many the next one has, and the work groups of its passes, so that the CPU need not wait
// for the numbers. A generation for which there are too few places has no rays; the CPU makes room and begins the tile anew.
#include "trace/shared.glsl"
#include "inputs/tracing/counts.glsl"
layout(local_size_x = 8) in;
uniform int level;          // of the generation that was shaded
uniform int next_capacity;  // rays that the next one has room for
uniform int head_capacity;
uniform uint most_groups;   // along x

void set_groups(int groups, uint items) {
    uint all = (items + uint(GROUP) - 1u) / uint(GROUP);
    uint rows = max((all + most_groups - 1u) / most_groups, 1u);
    count[groups] = (all + rows - 1u) / rows;
    count[groups + 1] = rows;
}

void main() {
    if (gl_GlobalInvocationID.x != 0u) return;
    int log = LOG + LOG_COUNTS * level;
    count[log + 3] = count[SHADOWS] = count[WAITING];
    uint front = count[ONWARD], rays = front + count[MIRRORED], heads = count[HEADS];
    if (rays > uint(next_capacity)) count[NEED_RAYS] = rays;
    if (heads > uint(head_capacity)) count[NEED_HEADS] = heads;
    if (count[NEED_RAYS] + count[NEED_HEADS] > 0u) rays = front = 0u;
    count[FIRST_HEAD] += count[CAST];
    count[CAST] = rays > 0u ? heads - count[FIRST_HEAD] : 0u;
    count[RAYS] = rays;
    count[FRONT] = front;
    log += LOG_COUNTS;
    count[log] = rays;
    count[log + 1] = front;
    count[log + 2] = count[CAST];
    set_groups(log + 4, rays);
    count[log + 6] = 1u;
    count[ONWARD] = count[MIRRORED] = count[WAITING] = count[ON_CLOTH] = count[ELSEWHERE] = 0u;
    uint rows = max((rays + uint(GROUP) * most_groups - 1u) / (uint(GROUP) * most_groups), 1u);
    count[COLUMN_RAYS] = rows * uint(GROUP);
    count[CLOTH_GROUPS] = count[OTHER_GROUPS] = 0u;  // passes/tracing/sort.comp counts them
    count[CLOTH_GROUPS + 1] = count[OTHER_GROUPS + 1] = rows;
    set_groups(RAY_GROUPS, (rays + uint(PART_SHARE) - 1u) / uint(PART_SHARE));
    set_groups(HEAD_GROUPS, count[CAST]);
    set_groups(SHADOW_GROUPS, count[SHADOWS]);
}
