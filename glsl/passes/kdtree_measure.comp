#version 430
// Large nodes, first of three passes a level: `lanes` invocations a node each go through every `lanes`-th reference.
// Each notes the box of its references, and how many lie left and right of the node's middle along each axis.
#include "trace/shared.glsl"
#include "trace/split.glsl"
layout(local_size_x = 64) in;
layout(binding = 1) uniform usamplerBuffer refs;
layout(binding = 2) uniform usamplerBuffer nodes;
layout(binding = 3) uniform usamplerBuffer active_nodes;
layout(std430, binding = 4) writeonly buffer Lanes { uvec4 lane_out[]; };  // (low, -) (high, -), then (left, right) of x and of y, of z
uniform int active_count;
uniform int lanes;

void main() {
    int i = int(gl_GlobalInvocationID.x);
    int index = i / lanes;
    if (index >= active_count) return;
    int self = int(texelFetch(active_nodes, index).x);
    uvec2 range = texelFetch(nodes, 4 * self + 3).xy;
    vec3 middle = 0.5 * (uintBitsToFloat(texelFetch(nodes, 4 * self).xyz) + uintBitsToFloat(texelFetch(nodes, 4 * self + 1).xyz));
    vec3 low = vec3(3e38);
    vec3 high = vec3(-3e38);
    uvec3 left = uvec3(0u);
    uvec3 right = uvec3(0u);
    int end = int(range.x + range.y);
    for (int r = int(range.x) + i % lanes; r < end; r += lanes) {
        vec3 l = uintBitsToFloat(texelFetch(refs, 2 * r).xyz);
        vec3 h = uintBitsToFloat(texelFetch(refs, 2 * r + 1).xyz);
        low = min(low, l);
        high = max(high, h);
        mat2x3 side = sides_of_middle(l, h, middle);
        left += uvec3(side[0]);
        right += uvec3(side[1]);
    }
    lane_out[4 * i] = uvec4(floatBitsToUint(low), 0u);
    lane_out[4 * i + 1] = uvec4(floatBitsToUint(high), 0u);
    lane_out[4 * i + 2] = uvec4(left.x, right.x, left.y, right.y);
    lane_out[4 * i + 3] = uvec4(left.z, right.z, 0u, 0u);
}
