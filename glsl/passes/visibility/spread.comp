#version 430
// Means at the vertices: the seen part over the whole, of the probes about them, four Gaussians at a time.   [own]
#include "trace/visibility.glsl"
layout(local_size_x = 64) in;        // and a row of groups for each four Gaussians
uniform usamplerBuffer sum_data;     // passes/visibility/mean.comp
uniform usamplerBuffer row_data;     // of a vertex: first term, the one after the last
uniform usamplerBuffer spread_data;  // terms: probe, weight as float
uniform samplerBuffer least_data;    // with no more than about this in sight, a Gaussian lights the other side
layout(std430) writeonly buffer Means { uint means[]; };  // unorm8 x 4: of a vertex front and back
uniform int last_item;               // vertices
uniform int group_count;

void main() {
    int i = int(gl_GlobalInvocationID.x), group = int(gl_WorkGroupID.y);
    if (i >= last_item) return;
    ivec2 row = ivec2(texelFetch(row_data, i).xy);
    vec4 front_all = texelFetch(least_data, group), back_all = front_all;
    vec4 front = 65535.0 * front_all, back = front;
    int e = row.x;
    do {
        uvec2 term = texelFetch(spread_data, e).xy;
        float weight = uintBitsToFloat(term.y);
        int at = 2 * int(term.x) * group_count + group;
        uvec4 sums = texelFetch(sum_data, at), sums_back = texelFetch(sum_data, at + group_count);
        front += weight * seen_of_sums(sums);
        front_all += weight * all_of_sums(sums);
        back += weight * seen_of_sums(sums_back);
        back_all += weight * all_of_sums(sums_back);
    } while (++e < row.y);
    means[2 * i * group_count + group] = packUnorm4x8(front / (65535.0 * front_all));
    means[(2 * i + 1) * group_count + group] = packUnorm4x8(back / (65535.0 * back_all));
}
