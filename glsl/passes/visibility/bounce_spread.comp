#version 430
// Mean bounced radiance at the vertices, front and back, from the probes about them.   [own]
layout(local_size_x = 64) in;
#include "inputs/gpu/item.glsl"
#include "trace/visibility.glsl"
uniform samplerBuffer sum_data;      // passes/visibility/bounce_gather.comp
uniform usamplerBuffer row_data;     // of a vertex: first term, the one after the last
uniform usamplerBuffer spread_data;  // terms: probe, weight as float
uniform usamplerBuffer mean_data;    // passes/visibility/spread.comp: V_0 of a vertex front and back
layout(std430) buffer Means { vec4 means[]; };  // of a vertex front and back: radiance; luminance x direction
uniform int vertex_count;
uniform int group_count;             // of mean_data
uniform bool again;                  // there is the first bounce; the sums are of two: find all of them
uniform vec3 most_reflected;         // by any surface

// A side of a vertex: its mean radiance, and of the luminance times the direction.
void put(int at, vec4 value, vec4 from, int mean) {
    if (again) {
        float hidden = 1.0 - unpackUnorm4x8(texelFetch(mean_data, mean * group_count).x).x;
        vec3 all = all_bounces(means[at].rgb, value.rgb, hidden * most_reflected);
        vec3 Y = vec3(0.2126, 0.7152, 0.0722);
        from *= dot(all, Y) / max(dot(value.rgb, Y), 1e-20);
        value.rgb = all;
    }
    means[at] = value;
    means[at + 1] = from;
}

void main() {
    int i = item();
    if (i >= vertex_count) return;
    ivec2 row = ivec2(texelFetch(row_data, i).xy);
    vec4 front = vec4(0.0), back = front, from = front, from_back = front;
    for (int e = row.x; e < row.y; ++e) {
        uvec2 term = texelFetch(spread_data, e).xy;
        float weight = uintBitsToFloat(term.y);
        int at = 4 * int(term.x);
        front += weight * texelFetch(sum_data, at);
        from += weight * texelFetch(sum_data, at + 1);
        back += weight * texelFetch(sum_data, at + 2);
        from_back += weight * texelFetch(sum_data, at + 3);
    }
    put(4 * i, front / max(front.w, 1e-12), from / max(front.w, 1e-12), 2 * i);
    put(4 * i + 2, back / max(back.w, 1e-12), from_back / max(back.w, 1e-12), 2 * i + 1);
}
