#version 430
// One reference for each triangle: its padded box and its number.   [Zhou 2008, section 3]
#include "trace/shared.glsl"
layout(local_size_x = 64) in;
layout(binding = 0) uniform usamplerBuffer corners;
layout(std430, binding = 1) writeonly buffer Refs { uvec4 ref_out[]; };
layout(std430, binding = 3) writeonly buffer Nodes { uvec4 node[]; };
layout(std430, binding = 6) writeonly buffer Active { uint next_active[]; };
uniform int triangle_count;
uniform float padding;

void main() {
    int i = int(gl_GlobalInvocationID.x);
    if (i >= triangle_count) return;
    vec3 a = uintBitsToFloat(texelFetch(corners, 3 * i).xyz);
    vec3 b = uintBitsToFloat(texelFetch(corners, 3 * i + 1).xyz);
    vec3 c = uintBitsToFloat(texelFetch(corners, 3 * i + 2).xyz);
    ref_out[2 * i] = uvec4(floatBitsToUint(min(a, min(b, c)) - padding), uint(i));
    ref_out[2 * i + 1] = uvec4(floatBitsToUint(max(a, max(b, c)) + padding), 0u);
    if (i == 0) {
        // The cell comes from passes/kdtree_root.comp.
        node[0] = uvec4(0u);
        node[1] = uvec4(0u);
        node[2] = uvec4(0u, PENDING, 0u, 0u);
        node[3] = uvec4(0u, uint(triangle_count), 0u, 0u);
        next_active[0] = 0u;
    }
}
