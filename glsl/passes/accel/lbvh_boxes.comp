#version 430
// The boxes of the nodes, from the triangles up: of the two children of a node the later one goes on.   [Karras 2012]
layout(local_size_x = 64) in;
#include "inputs/gpu/item.glsl"
uniform usamplerBuffer corners;
uniform usamplerBuffer keys;
uniform usamplerBuffer tree;
uniform usamplerBuffer parents;
layout(std430) coherent buffer Boxes { vec4 box[]; };  // low and high of the nodes, then of the keys
layout(std430) coherent buffer Arrivals { uint arrivals[]; };
uniform int key_count;
uniform float padding;

void main() {
    int i = item();
    if (i >= key_count) return;
    int triangle = int(texelFetch(keys, i).y);
    vec3 a = uintBitsToFloat(texelFetch(corners, 3 * triangle).xyz);
    vec3 b = uintBitsToFloat(texelFetch(corners, 3 * triangle + 1).xyz);
    vec3 c = uintBitsToFloat(texelFetch(corners, 3 * triangle + 2).xyz);
    int at = key_count - 1 + i;
    vec3 low = min(a, min(b, c)) - padding;
    vec3 high = max(a, max(b, c)) + padding;
    box[2 * at] = vec4(low, 0.0);
    box[2 * at + 1] = vec4(high, 0.0);
    uint up = key_count > 1 ? texelFetch(parents, at).x : 0xffffffffu;
    while (up != 0xffffffffu) {
        memoryBarrierBuffer();
        if (atomicAdd(arrivals[up], 1u) == 0u) return;
        memoryBarrierBuffer();
        uvec2 child = texelFetch(tree, int(up)).xy;
        uint l = (child.x & 0x80000000u) != 0u ? uint(key_count - 1) + (child.x & 0x7fffffffu) : child.x;
        uint r = (child.y & 0x80000000u) != 0u ? uint(key_count - 1) + (child.y & 0x7fffffffu) : child.y;
        box[2u * up] = min(box[2u * l], box[2u * r]);
        box[2u * up + 1u] = max(box[2u * l + 1u], box[2u * r + 1u]);
        up = texelFetch(parents, int(up)).x;
    }
}
