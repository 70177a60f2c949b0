#version 430
// What patches send besides, because the curtain leans: once more of what its cells send, by how much more of them is seen.
layout(local_size_x = 64) in;
#include "inputs/gpu/item.glsl"
uniform samplerBuffer sent;
uniform samplerBuffer changes;   // cell by cell, of each patch: how its factor differs at the known leans from that without
uniform samplerBuffer leans;     // weights of these, column by column
uniform samplerBuffer shares;    // reflectances
layout(std430) writeonly buffer Leaning { vec4 leaning[]; };
uniform int patch_count;
uniform int cell_count;          // front and back
uniform int across;              // cells in a row
uniform int sender_count;

void main() {
    int i = item();
    if (i >= sender_count) return;
    vec3 before = texelFetch(sent, i).rgb;
    if (i >= patch_count) {
        leaning[i] = vec4(before, 0.0);
        return;
    }
    vec3 sum = vec3(0.0);
    int k = 0;
    do {
        float F = dot(texelFetch(changes, k * patch_count + i), texelFetch(leans, k % across));
        sum += F * texelFetch(sent, patch_count + k).rgb;
        ++k;
    } while (k < cell_count);
    leaning[i] = vec4(max(before + texelFetch(shares, i).rgb * sum, vec3(0.0)), 0.0);
}
