#version 430
// For each small root: the six faces of its references' boxes as candidate planes, and for each candidate the sets of
// references left and right of it as 64-bit masks.   [Zhou 2008, section 3.2]
// A root with the mark of a large leaf has no candidates. Masks: texel 6 i + c belongs to face c (three low, three high)
// of reference i: (left 0-31, left 32-63, right 0-31, right 32-63).
#include "trace/shared.glsl"
layout(local_size_x = 16) in;
#include "inputs/gpu/item.glsl"
#include "inputs/accel/kdtree_small.glsl"
uniform usamplerBuffer roots;
uniform usamplerBuffer refs;
layout(std430) writeonly buffer Nodes { uvec4 node[]; };
layout(std430) writeonly buffer Active { uint next_active[]; };
layout(std430) writeonly buffer Masks { uvec4 mask[]; };
uniform int small_base;      // where the references of small nodes begin; masks are counted from there

vec3 ref_low(uint r) { return uintBitsToFloat(texelFetch(refs, int(2u * r)).xyz); }
vec3 ref_high(uint r) { return uintBitsToFloat(texelFetch(refs, int(2u * r) + 1).xyz); }

uint low_bits(int n) { return n >= 32 ? 0xffffffffu : n <= 0 ? 0u : (1u << n) - 1u; }

void main() {
    int index = group();
    if (index >= int(counter[ROOT_COUNT])) return;
    uvec4 root = texelFetch(roots, index);
    if (root.w != 0u) return;
    uint first = root.y;
    int count = int(root.z);
    for (int i = int(gl_LocalInvocationID.x); i < count; i += 16) {
        vec3 low = ref_low(first + uint(i));
        vec3 high = ref_high(first + uint(i));
        uvec4 m[6] = uvec4[6](uvec4(0u), uvec4(0u), uvec4(0u), uvec4(0u), uvec4(0u), uvec4(0u));
        for (int j = 0; j < count; ++j) {
            vec3 l = ref_low(first + uint(j));
            vec3 h = ref_high(first + uint(j));
            uvec2 bit = j < 32 ? uvec2(1u << j, 0u) : uvec2(0u, 1u << (j - 32));
            for (int c = 0; c < 6; ++c) {
                float plane = c < 3 ? low[c] : high[c - 3];
                int axis = c < 3 ? c : c - 3;
                bool right = h[axis] > plane;
                bool left = l[axis] < plane || !right;
                m[c] |= uvec4(left ? bit : uvec2(0u), right ? bit : uvec2(0u));
            }
        }
        for (int c = 0; c < 6; ++c) mask[6u * (first - uint(small_base) + uint(i)) + uint(c)] = m[c];
    }
    if (gl_LocalInvocationID.x == 0u) {
        node[4u * root.x + 3u] = uvec4(low_bits(count), low_bits(count - 32), first, 0u);
        next_active[next_small(0, 1u)] = root.x;
    }
}
