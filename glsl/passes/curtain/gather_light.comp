#version 430
// Irradiance of receivers: of the sky, and of what senders send, attenuated where the curtain is on the way.
layout(local_size_x = 64) in;
#include "inputs/gpu/item.glsl"
uniform samplerBuffer factors;    // of four senders at a time, receiver by receiver; negative: through the curtain
uniform samplerBuffer sent;
uniform samplerBuffer sky_light;  // of each receiver, as the curtain leans by the four known leans
uniform samplerBuffer leans;      // weights of these; behind those of the columns the mean
layout(std430) writeonly buffer Received { vec4 received[]; };
uniform int receiver_count;
uniform int sender_count;
uniform int mean_lean;
uniform vec3 passes;              // what the curtain lets straight through

// Light of four senders by their factors.
vec3 from_four(vec4 F, vec3 a, vec3 b, vec3 c, vec3 d) {
    return F.x * (F.x < 0.0 ? -passes * a : a) + F.y * (F.y < 0.0 ? -passes * b : b)
           + F.z * (F.z < 0.0 ? -passes * c : c) + F.w * (F.w < 0.0 ? -passes * d : d);
}

vec3 sky_at(int r) {
    vec4 w = texelFetch(leans, mean_lean);
    return w.x * texelFetch(sky_light, 4 * r).rgb + w.y * texelFetch(sky_light, 4 * r + 1).rgb
           + w.z * texelFetch(sky_light, 4 * r + 2).rgb + w.w * texelFetch(sky_light, 4 * r + 3).rgb;
}

// An invocation takes four receivers, so that it reads what is sent once for all of them.
void main() {
    int i = item();
    int share = (receiver_count + 3) / 4;
    if (i >= share) return;
    ivec4 r = i + share * ivec4(0, 1, 2, 3);
    ivec4 read = min(r, receiver_count - 1);
    vec3 sum_0 = vec3(0.0);
    vec3 sum_1 = vec3(0.0);
    vec3 sum_2 = vec3(0.0);
    vec3 sum_3 = vec3(0.0);
    int last = sender_count - 1;
    int k = 0;
    do {
        // Behind the last sender factors are 0.
        vec3 a = texelFetch(sent, k).rgb;
        vec3 b = texelFetch(sent, min(k + 1, last)).rgb;
        vec3 c = texelFetch(sent, min(k + 2, last)).rgb;
        vec3 d = texelFetch(sent, min(k + 3, last)).rgb;
        int row = (k >> 2) * receiver_count;
        sum_0 += from_four(texelFetch(factors, row + read.x), a, b, c, d);
        sum_1 += from_four(texelFetch(factors, row + read.y), a, b, c, d);
        sum_2 += from_four(texelFetch(factors, row + read.z), a, b, c, d);
        sum_3 += from_four(texelFetch(factors, row + read.w), a, b, c, d);
        k += 4;
    } while (k < sender_count);
    received[r.x] = vec4(sky_at(r.x) + sum_0, 0.0);
    if (r.y < receiver_count) received[r.y] = vec4(sky_at(r.y) + sum_1, 0.0);
    if (r.z < receiver_count) received[r.z] = vec4(sky_at(r.z) + sum_2, 0.0);
    if (r.w < receiver_count) received[r.w] = vec4(sky_at(r.w) + sum_3, 0.0);
}
