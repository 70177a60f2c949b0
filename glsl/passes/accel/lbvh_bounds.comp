#version 430
// The box of every LANES-th triangle's corners, for the box of all.
layout(local_size_x = 64) in;
#include "inputs/gpu/item.glsl"
uniform usamplerBuffer corners;
layout(std430) writeonly buffer Lanes { vec4 lane_out[]; };  // low, high
uniform int triangle_count;
uniform int lanes;

void main() {
    int lane = item();
    if (lane >= lanes) return;
    vec3 low = vec3(3e38);
    vec3 high = vec3(-3e38);
    for (int i = lane; i < triangle_count; i += lanes) {
        for (int k = 0; k < 3; ++k) {
            vec3 p = uintBitsToFloat(texelFetch(corners, 3 * i + k).xyz);
            low = min(low, p);
            high = max(high, p);
        }
    }
    lane_out[2 * lane] = vec4(low, 0.0);
    lane_out[2 * lane + 1] = vec4(high, 0.0);
}
