#version 430
// The boxes of the nodes, from the triangles up: of the two children of a node the later one goes on.   [Karras 2012]
layout(local_size_x = 64) in;
#include "inputs/gpu/item.glsl"
#include "inputs/accel/key_box.glsl"
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
    vec3 low, high;
    key_box(int(texelFetch(keys, i).y), low, high);
    int at = key_count - 1 + i;
    box[2 * at] = vec4(low - padding, 0.0);
    box[2 * at + 1] = vec4(high + padding, 0.0);
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
