#version 430
// Large nodes, first of three passes a level: LANES_NOW invocations a node each go through every LANES_NOW-th reference.
// Each notes the box of its references, and how many lie left and right of LARGE_PLANES planes across each axis.
#include "trace/shared.glsl"
#include "trace/split.glsl"
layout(local_size_x = 64) in;
#include "inputs/gpu/item.glsl"
uniform usamplerBuffer nodes;
uniform usamplerBuffer active_nodes;
uniform usamplerBuffer refs;
// LANE_TEXELS each: (low, -) (high, -), then for every plane (counts across x, y, z, -) as side_counts() packs them
layout(std430) writeonly buffer Lanes { uvec4 lane_out[]; };
layout(std430) readonly buffer Counters { uint counter[]; };

void main() {
    int i = item();
    int lanes = int(counter[LANES_NOW]);
    int index = i / lanes;
    if (index >= int(counter[ACTIVE_NOW])) return;
    int self = int(texelFetch(active_nodes, index).x);
    uvec2 range = texelFetch(nodes, 4 * self + 3).xy;
    vec3 cell_low = uintBitsToFloat(texelFetch(nodes, 4 * self).xyz);
    vec3 cell_high = uintBitsToFloat(texelFetch(nodes, 4 * self + 1).xyz);
    vec3 planes[LARGE_PLANES];
    uvec3 counts[LARGE_PLANES];
    for (int k = 0; k < LARGE_PLANES; ++k) {
        planes[k] = planes_at(cell_low, cell_high, plane_fraction(k, LARGE_PLANES));
        counts[k] = uvec3(0u);
    }
    vec3 low = vec3(3e38);
    vec3 high = vec3(-3e38);
    int end = int(range.x + range.y);
    for (int r = int(range.x) + i % lanes; r < end; r += lanes) {
        vec3 l = uintBitsToFloat(texelFetch(refs, 2 * r).xyz);
        vec3 h = uintBitsToFloat(texelFetch(refs, 2 * r + 1).xyz);
        low = min(low, l);
        high = max(high, h);
        for (int k = 0; k < LARGE_PLANES; ++k) {
            counts[k] += side_counts(l, h, planes[k]);
        }
    }
    int at = LANE_TEXELS * i;
    lane_out[at] = uvec4(floatBitsToUint(low), 0u);
    lane_out[at + 1] = uvec4(floatBitsToUint(high), 0u);
    for (int k = 0; k < LARGE_PLANES; ++k) {
        lane_out[at + 2 + k] = uvec4(counts[k], 0u);
    }
}
