#version 430
// Radix sort, third of three passes a digit: each chunk puts its keys in their places, in order, so the sort is stable.
#include "trace/shared.glsl"
layout(local_size_x = 8) in;
#include "inputs/gpu/item.glsl"
uniform usamplerBuffer keys;
uniform usamplerBuffer begins;
layout(std430) writeonly buffer Keys { uvec2 key_out[]; };
uniform int key_count;
uniform int chunk_count;
uniform int shift;

void main() {
    int chunk = item();
    if (chunk >= chunk_count) return;
    const int DIGITS = 1 << SORT_BITS;
    uint at[DIGITS];
    for (int d = 0; d < DIGITS; ++d) at[d] = texelFetch(begins, d * chunk_count + chunk).x;
    int end = min((chunk + 1) * SORT_CHUNK, key_count);
    for (int i = chunk * SORT_CHUNK; i < end; ++i) {
        uvec2 key = texelFetch(keys, i).xy;
        key_out[at[(key.x >> uint(shift)) & uint(DIGITS - 1)]++] = key;
    }
}
