#version 430
// The root's cell: the box of all references, from the lanes of the first measurement.
#include "trace/shared.glsl"
layout(local_size_x = 8) in;
#include "inputs/gpu/item.glsl"
uniform usamplerBuffer lane_data;
layout(std430) writeonly buffer Nodes { uvec4 node[]; };
layout(std430) readonly buffer Counters { uint counter[]; };

void main() {
    if (item() != 0) return;
    int lanes = int(counter[LANES_NOW]);
    vec3 low = vec3(3e38);
    vec3 high = vec3(-3e38);
    for (int i = 0; i < lanes; ++i) {
        low = min(low, uintBitsToFloat(texelFetch(lane_data, LANE_TEXELS * i).xyz));
        high = max(high, uintBitsToFloat(texelFetch(lane_data, LANE_TEXELS * i + 1).xyz));
    }
    node[0] = uvec4(floatBitsToUint(low), 0u);
    node[1] = uvec4(floatBitsToUint(high), 0u);
}
