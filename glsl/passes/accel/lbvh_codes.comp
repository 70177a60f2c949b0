#version 430
// The Morton code of each triangle's middle.   [Karras 2012]
#include "trace/morton.glsl"
layout(local_size_x = 64) in;
#include "inputs/gpu/item.glsl"
uniform usamplerBuffer corners;
layout(std430) writeonly buffer Keys { uvec2 key_out[]; };  // code, triangle
uniform int triangle_count;
uniform vec3 scene_low;
uniform vec3 scene_high;

void main() {
    int i = item();
    if (i >= triangle_count) return;
    vec3 a = uintBitsToFloat(texelFetch(corners, 3 * i).xyz);
    vec3 b = uintBitsToFloat(texelFetch(corners, 3 * i + 1).xyz);
    vec3 c = uintBitsToFloat(texelFetch(corners, 3 * i + 2).xyz);
    vec3 middle = 0.5 * (min(a, min(b, c)) + max(a, max(b, c)));
    key_out[i] = uvec2(morton_code((middle - scene_low) / max(scene_high - scene_low, vec3(1e-30))), uint(i));
}
