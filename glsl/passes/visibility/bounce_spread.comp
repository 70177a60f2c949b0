#version 430
// Mean bounced radiance at the vertices, front and back, from the probes about them, and the share of rays that surfaces end.   [own]
layout(local_size_x = 64) in;
#include "inputs/gpu/item.glsl"
uniform samplerBuffer sum_data;      // passes/visibility/bounce_gather.comp
uniform usamplerBuffer row_data;     // of a vertex: first term, the one after the last
uniform usamplerBuffer spread_data;  // terms: probe, weight as float
layout(std430) writeonly buffer Means { vec4 means[]; };  // of a vertex front and back: radiance; luminance x direction, hidden share
uniform int vertex_count;

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
    means[4 * i] = front / max(front.w, 1e-12);
    means[4 * i + 1] = from / max(front.w, 1e-12);
    means[4 * i + 2] = back / max(back.w, 1e-12);
    means[4 * i + 3] = from_back / max(back.w, 1e-12);
}
