#version 430
// Large nodes, third of three passes a level: LANES_NOW invocations a node copy its references to the children, those that
// straddle the plane to both, with the boxes of their parts.   [Zhou 2008, section 3.1]
// Each lane goes through the references that it counted in the first pass, so it knows where its own begin: the order
// within a child does not depend on timing.
#include "trace/shared.glsl"
#include "trace/intersect.glsl"
#include "trace/split.glsl"
layout(local_size_x = 64) in;
#include "inputs/gpu/item.glsl"
uniform usamplerBuffer nodes;
uniform usamplerBuffer active_nodes;
uniform usamplerBuffer refs;
uniform usamplerBuffer lane_data;
uniform usamplerBuffer corners;
layout(std430) writeonly buffer Refs { uvec4 ref_out[]; };
layout(std430) readonly buffer Counters { uint counter[]; };
uniform float padding;

// The box of a triangle's part, padded, within the box that the reference had; as it was when rounding leaves nothing.
mat2x3 narrowed(mat3 part, vec3 low, vec3 high) {
    vec3 new_low = max(low, part[0] - padding);
    vec3 new_high = min(high, part[1] + padding);
    bool some = part[2].x > 0.0 && all(lessThanEqual(new_low, new_high));
    return some ? mat2x3(new_low, new_high) : mat2x3(low, high);
}

// The box of the part on one side of the plane of two triangles (a, c, b) and (b, c, d).
mat3 clipped_pair(vec3 a, vec3 b, vec3 c, vec3 d, vec4 plane, float side) {
    mat3 p = clipped_box(a, b, c, plane.xyz, plane.w, side);
    mat3 q = clipped_box(d, b, c, plane.xyz, plane.w, side);
    bool both = p[2].x * q[2].x > 0.0;
    return both ? mat3(min(p[0], q[0]), max(p[1], q[1]), p[2]) : p[2].x > 0.0 ? p : q;
}

void put(uint at, vec3 low, vec3 high, uint pair) {
    ref_out[2u * at] = uvec4(floatBitsToUint(low), pair);
    ref_out[2u * at + 1u] = uvec4(floatBitsToUint(high), 0u);
}

void main() {
    int i = item();
    int lanes = int(counter[LANES_NOW]);
    int index = i / lanes;
    int lane = i % lanes;
    if (index >= int(counter[ACTIVE_NOW])) return;
    int self = int(texelFetch(active_nodes, index).x);
    uvec4 range = texelFetch(nodes, 4 * self + 3);
    uvec4 head = texelFetch(nodes, 4 * self + 2);  // (first child, kind, -, where its lanes hold the counts)
    int end = int(range.x + range.y);
    uvec2 at;
    vec4 plane = vec4(1.0, 0.0, 0.0, 3e38);
    bool fits_left = true;
    bool fits_right = true;
    if (head.y == LARGE_LEAF) {
        at = uvec2(range.z, 0u);
        range.w = 1u;
    } else {
        uvec2 left = texelFetch(nodes, int(4u * head.x) + 3).xy;
        uvec2 right = texelFetch(nodes, int(4u * head.x) + 7).xy;
        at = uvec2(left.x, right.x);
        // A child without room has no references.
        fits_left = left.y != 0u;
        fits_right = right.y != 0u;
        uint axis = texelFetch(nodes, 4 * self + 1).w;
        vec3 n = axis == 0u ? vec3(1.0, 0.0, 0.0) : axis == 1u ? vec3(0.0, 1.0, 0.0) : vec3(0.0, 0.0, 1.0);
        plane = vec4(n, uintBitsToFloat(texelFetch(nodes, 4 * self).w));
    }
    if (range.w != 0u) {
        // Everything goes one way: lanes take runs of their own.
        uint share = (range.y + uint(lanes) - 1u) / uint(lanes);
        uint begin = min(uint(lane) * share, range.y);
        end = int(range.x + min(begin + share, range.y));
        uint to = (range.w == 1u ? at.x : at.y) + begin;
        if (range.w == 1u ? fits_left : fits_right)
            for (int r = int(range.x + begin); r < end; ++r) {
                ref_out[2u * to] = texelFetch(refs, 2 * r);
                ref_out[2u * to + 1u] = texelFetch(refs, 2 * r + 1);
                ++to;
            }
        return;
    }
    for (int k = i - lane; k < i; ++k) {
        uvec3 counts = texelFetch(lane_data, LANE_TEXELS * k + int(head.w)).xyz;
        uint both = plane.x > 0.0 ? counts.x : plane.y > 0.0 ? counts.y : counts.z;
        at += uvec2(both & 0xffffu, both >> 16u);
    }
    for (int r = int(range.x) + lane; r < end; r += lanes) {
        uvec4 first = texelFetch(refs, 2 * r);
        vec3 low = uintBitsToFloat(first.xyz);
        vec3 high = uintBitsToFloat(texelFetch(refs, 2 * r + 1).xyz);
        vec2 side = sides(low, high, plane);
        bool left = side.x > 0.0;
        if (side.x * side.y > 0.0) {
            int corner = int(3u * (first.w >> 1));
            vec3 a = uintBitsToFloat(texelFetch(corners, corner).xyz);
            vec3 c = uintBitsToFloat(texelFetch(corners, corner + 1).xyz);
            vec3 b = uintBitsToFloat(texelFetch(corners, corner + 2).xyz);
            vec3 d = (first.w & 1u) != 0u ? uintBitsToFloat(texelFetch(corners, corner + 5).xyz) : a;
            mat2x3 part = narrowed(clipped_pair(a, b, c, d, plane, -1.0), low, high);
            part[0] = mix(part[0], max(part[0], vec3(plane.w)), plane.xyz);
            if (fits_right) put(at.y, part[0], part[1], first.w);
            ++at.y;
            part = narrowed(clipped_pair(a, b, c, d, plane, 1.0), low, high);
            low = part[0];
            high = mix(part[1], min(part[1], vec3(plane.w)), plane.xyz);
        }
        if (left ? fits_left : fits_right) put(left ? at.x : at.y, low, high, first.w);
        if (left) ++at.x; else ++at.y;
    }
}
