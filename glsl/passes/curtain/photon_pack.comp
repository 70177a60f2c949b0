#version 430
// Writes the arrivals of photons one behind the other, in the order of the photons.
layout(local_size_x = 64) in;
#include "inputs/gpu/item.glsl"
uniform usamplerBuffer slots;     // passes/curtain/photon_trace.comp
uniform usamplerBuffer begins;    // of each photon its first arrival
layout(std430) writeonly buffer Photons { uvec4 photon[]; };
uniform int photon_count;
uniform int slots_each;
uniform int first;                // where they are written

void main() {
    int i = item();
    if (i >= photon_count) return;
    int begin = int(texelFetch(begins, i).x), end = int(texelFetch(begins, i + 1).x);
    int from = 2 * slots_each * i;
    int to = 2 * (first + begin);
    int last = to + 2 * (end - begin);
    do {
        if (to < last) photon[to] = texelFetch(slots, from);
        ++from;
        ++to;
    } while (to < last);
}
