#version 430
// What senders send of the light that comes straight from the lamp, and of the sky's: S = S_sky + weight x mean of samples.
layout(local_size_x = 64) in;
#include "inputs/gpu/item.glsl"
uniform samplerBuffer lights;   // of samples, what arrived
uniform samplerBuffer sky;      // S_sky of each sender
uniform samplerBuffer shares;   // of the mean, its light that is sent
uniform usamplerBuffer lists;   // samples of each sender, in `listed`: first, number
uniform usamplerBuffer listed;  // a sample, its weight
layout(std430) writeonly buffer Sources { vec4 sources[]; };
uniform int sender_count;

void main() {
    int i = item();
    if (i >= sender_count) return;
    uvec2 list = texelFetch(lists, i).xy;
    vec3 sum = vec3(0.0);
    for (uint k = list.x; k < list.x + list.y; ++k) {
        uvec2 entry = texelFetch(listed, int(k)).xy;
        sum += uintBitsToFloat(entry.y) * texelFetch(lights, int(entry.x)).rgb;
    }
    sources[i] = vec4(texelFetch(sky, i).rgb + texelFetch(shares, i).rgb * sum, 0.0);
}
