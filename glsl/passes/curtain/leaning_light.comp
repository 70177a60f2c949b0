#version 430
// Adds to the irradiance of the room what the cells of the curtain send, as each of its columns leans, and what its lean lets by or
// keeps of what patches send.
layout(local_size_x = 64) in;
#include "inputs/gpu/item.glsl"
uniform samplerBuffer cells;      // cell by cell, of each element: factors at four leans; negative: of the cell's back
uniform samplerBuffer leans;      // weights of these, column by column
uniform samplerBuffer sent;
uniform usamplerBuffer lists;     // of each element: its first entry in `crossing`, and how many
uniform samplerBuffer crossing;   // how much more of a factor crosses at the second lean, the third, the fourth; 16 sender + column
layout(std430) buffer Received { vec4 received[]; };
uniform int element_count;
uniform int patch_count;
uniform int cell_count;           // of a side
uniform int across;               // cells in a row
uniform vec3 passes;              // what the curtain lets straight through

vec3 from_cell(vec4 F, vec4 lean, vec3 front, vec3 back) {
    return max(dot(max(F, vec4(0.0)), lean), 0.0) * front + max(dot(max(-F, vec4(0.0)), lean), 0.0) * back;
}

vec3 let_by(int i) {
    uvec2 list = texelFetch(lists, i).xy;
    vec3 sum = vec3(0.0);
    for (uint k = list.x; k < list.x + list.y; ++k) {
        vec4 entry = texelFetch(crossing, int(k));
        int who = int(entry.w);
        float more = dot(entry.xyz, texelFetch(leans, who & 15).yzw);
        sum -= more * texelFetch(sent, who >> 4).rgb;
    }
    return sum * (vec3(1.0) - passes);
}

// An invocation takes four elements, so that it reads what is sent once for all of them.
void main() {
    int i = item();
    int share = (element_count + 3) / 4;
    if (i >= share) return;
    ivec4 r = i + share * ivec4(0, 1, 2, 3);
    ivec4 read = min(r, element_count - 1);
    vec3 sum_0 = vec3(0.0);
    vec3 sum_1 = vec3(0.0);
    vec3 sum_2 = vec3(0.0);
    vec3 sum_3 = vec3(0.0);
    int k = 0;
    do {
        vec4 lean = texelFetch(leans, k % across);
        vec3 front = texelFetch(sent, patch_count + k).rgb;
        vec3 back = texelFetch(sent, patch_count + cell_count + k).rgb;
        int row = k * element_count;
        sum_0 += from_cell(texelFetch(cells, row + read.x), lean, front, back);
        sum_1 += from_cell(texelFetch(cells, row + read.y), lean, front, back);
        sum_2 += from_cell(texelFetch(cells, row + read.z), lean, front, back);
        sum_3 += from_cell(texelFetch(cells, row + read.w), lean, front, back);
        ++k;
    } while (k < cell_count);
    received[r.x].rgb = max(received[r.x].rgb + sum_0 + let_by(read.x), vec3(0.0));
    if (r.y < element_count) received[r.y].rgb = max(received[r.y].rgb + sum_1 + let_by(read.y), vec3(0.0));
    if (r.z < element_count) received[r.z].rgb = max(received[r.z].rgb + sum_2 + let_by(read.z), vec3(0.0));
    if (r.w < element_count) received[r.w].rgb = max(received[r.w].rgb + sum_3 + let_by(read.w), vec3(0.0));
}
