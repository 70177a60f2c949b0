#version 430
// The Morton code of the middle of each triangle, or piece of one.   [Karras 2012]
#include "trace/morton.glsl"
#include "inputs/accel/key_box.glsl"
layout(local_size_x = 64) in;
#include "inputs/gpu/item.glsl"
layout(std430) writeonly buffer Keys { uvec2 key_out[]; };  // code, triangle or piece
uniform int key_count;
uniform vec3 scene_low;
uniform vec3 scene_high;

void main() {
    int i = item();
    if (i >= key_count) return;
    vec3 low, high;
    key_box(i, low, high);
    vec3 middle = 0.5 * (low + high);
    key_out[i] = uvec2(morton_code((middle - scene_low) / max(scene_high - scene_low, vec3(1e-30))), uint(i));
}
