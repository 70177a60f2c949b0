#version 430
// One reference for each pair of triangles that share an edge, or triangle without a partner: its padded box and its code
// (the first triangle's number times two, plus one if its successor belongs to it).   [Zhou 2008, section 3]
#include "trace/shared.glsl"
layout(local_size_x = 64) in;
#include "inputs/gpu/item.glsl"
uniform usamplerBuffer corners;
uniform usamplerBuffer pairs;
layout(std430) writeonly buffer Refs { uvec4 ref_out[]; };
layout(std430) writeonly buffer Nodes { uvec4 node[]; };
layout(std430) writeonly buffer Active { uint next_active[]; };
uniform int pair_count;
uniform float padding;

void main() {
    int i = item();
    if (i >= pair_count) return;
    uint pair = texelFetch(pairs, i).x;
    int first = int(3u * (pair >> 1));
    vec3 a = uintBitsToFloat(texelFetch(corners, first).xyz);
    vec3 b = uintBitsToFloat(texelFetch(corners, first + 1).xyz);
    vec3 c = uintBitsToFloat(texelFetch(corners, first + 2).xyz);
    vec3 d = (pair & 1u) != 0u ? uintBitsToFloat(texelFetch(corners, first + 5).xyz) : c;
    ref_out[2 * i] = uvec4(floatBitsToUint(min(min(a, d), min(b, c)) - padding), pair);
    ref_out[2 * i + 1] = uvec4(floatBitsToUint(max(max(a, d), max(b, c)) + padding), 0u);
    if (i == 0) {
        // The cell comes from passes/accel/kdtree_root.comp.
        node[0] = uvec4(0u);
        node[1] = uvec4(0u);
        node[2] = uvec4(0u, PENDING, 0u, 0u);
        node[3] = uvec4(0u, uint(pair_count), 0u, 0u);
        next_active[0] = 0u;
    }
}
