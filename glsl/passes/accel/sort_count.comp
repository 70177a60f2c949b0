#version 430
// Radix sort, first of three passes a digit: how often each digit occurs in each chunk of keys.
#include "trace/shared.glsl"
layout(local_size_x = 8) in;
#include "inputs/gpu/item.glsl"
uniform usamplerBuffer keys;
layout(std430) writeonly buffer Histogram { uint histogram[]; };  // by digit, then by chunk
uniform int key_count;
uniform int chunk_count;
uniform int shift;

void main() {
    int chunk = item();
    if (chunk >= chunk_count) return;
    const int DIGITS = 1 << SORT_BITS;
    uint times[DIGITS];
    for (int d = 0; d < DIGITS; ++d) times[d] = 0u;
    int end = min((chunk + 1) * SORT_CHUNK, key_count);
    for (int i = chunk * SORT_CHUNK; i < end; ++i)
        times[(texelFetch(keys, i).x >> uint(shift)) & uint(DIGITS - 1)] += 1u;
    for (int d = 0; d < DIGITS; ++d) histogram[d * chunk_count + chunk] = times[d];
}
