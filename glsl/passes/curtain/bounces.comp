#version 430
// What senders send after all bounces: B = M S, M = (1 - K)^-1 with K all that one bounce does. Element by element in a
// fixed order, so that the bits repeat.
layout(local_size_x = 64) in;
#include "inputs/gpu/item.glsl"
uniform samplerBuffer bounces;  // M, column by column
uniform samplerBuffer sources;
layout(std430) writeonly buffer Sent { vec4 sent[]; };
uniform int sender_count;

void main() {
    int i = item();
    if (i >= sender_count) return;
    vec3 sum = vec3(0.0);
    int k = 0;
    do {
        sum += texelFetch(bounces, k * sender_count + i).rgb * texelFetch(sources, k).rgb;
        ++k;
    } while (k < sender_count);
    sent[i] = vec4(sum, 0.0);
}
