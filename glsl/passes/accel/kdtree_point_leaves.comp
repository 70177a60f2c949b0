#version 430
// The points in leaf order, so that a leaf is read in one run.
#include "trace/shared.glsl"
layout(local_size_x = 64) in;
#include "inputs/gpu/item.glsl"
uniform usamplerBuffer points;
uniform usamplerBuffer leaf_pairs;
layout(std430) writeonly buffer LeafPoints { uvec4 leaf_point[]; };
layout(std430) readonly buffer Counters { uint counter[]; };

void main() {
    int i = item();
    if (i >= int(counter[LEAF_REF_COUNT])) return;
    int point = int(texelFetch(leaf_pairs, i).x >> 1);
    leaf_point[2 * i] = texelFetch(points, 2 * point);
    leaf_point[2 * i + 1] = texelFetch(points, 2 * point + 1);
}
