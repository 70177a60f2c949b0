#version 430
// Irradiance of receivers: of the sky, and of what senders send, attenuated where the curtain is on the way.
layout(local_size_x = 64) in;
#include "inputs/gpu/item.glsl"
uniform samplerBuffer factors;    // by senders; negative: through the curtain
uniform samplerBuffer sent;
uniform samplerBuffer sky_light;  // of each receiver
layout(std430) writeonly buffer Received { vec4 received[]; };
uniform int receiver_count;
uniform int sender_count;
uniform vec3 passes;              // what the curtain lets straight through

void main() {
    int i = item();
    if (i >= receiver_count) return;
    vec3 here = vec3(0.0);
    vec3 behind = vec3(0.0);
    int k = 0;
    do {
        float F = texelFetch(factors, k * receiver_count + i).r;
        vec3 light = texelFetch(sent, k).rgb;
        here += max(F, 0.0) * light;
        behind += max(-F, 0.0) * light;
        ++k;
    } while (k < sender_count);
    received[i] = vec4(texelFetch(sky_light, i).rgb + here + passes * behind, 0.0);
}
