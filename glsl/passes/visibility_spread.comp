#version 430
// Means at the vertices: what the probes about them see over what there is to see, four Gaussians at a time.   [own]
layout(local_size_x = 64) in;
layout(binding = 9) uniform usamplerBuffer sum_data;      // passes/visibility_mean.comp
layout(binding = 10) uniform usamplerBuffer row_data;     // of a vertex: first term, the one after the last
layout(binding = 11) uniform usamplerBuffer spread_data;  // terms: probe, weight as float
layout(std430, binding = 0) writeonly buffer Means { uint means[]; };  // unorm8 x 4: of a vertex front and back
uniform int last_item;    // vertices
uniform int group;
uniform int group_count;
uniform vec4 least;       // with no more than about this in sight, a Gaussian lights the other side

void main() {
    int i = int(gl_GlobalInvocationID.x);
    if (i >= last_item) return;
    ivec2 row = ivec2(texelFetch(row_data, i).xy);
    vec4 front = 0.5 * least, front_all = front, back = front, back_all = front;
    int e = row.x;
    do {
        uvec2 term = texelFetch(spread_data, e).xy;
        float weight = uintBitsToFloat(term.y);
        int at = 8 * int(term.x) * group_count + 4 * group;
        vec2 a = unpackHalf2x16(texelFetch(sum_data, at).x), b = unpackHalf2x16(texelFetch(sum_data, at + 1).x);
        vec2 c = unpackHalf2x16(texelFetch(sum_data, at + 2).x), d = unpackHalf2x16(texelFetch(sum_data, at + 3).x);
        front += weight * vec4(a.x, b.x, c.x, d.x);
        front_all += weight * vec4(a.y, b.y, c.y, d.y);
        at += 4 * group_count;
        a = unpackHalf2x16(texelFetch(sum_data, at).x);
        b = unpackHalf2x16(texelFetch(sum_data, at + 1).x);
        c = unpackHalf2x16(texelFetch(sum_data, at + 2).x);
        d = unpackHalf2x16(texelFetch(sum_data, at + 3).x);
        back += weight * vec4(a.x, b.x, c.x, d.x);
        back_all += weight * vec4(a.y, b.y, c.y, d.y);
    } while (++e < row.y);
    means[2 * i * group_count + group] = packUnorm4x8(front / front_all);
    means[(2 * i + 1) * group_count + group] = packUnorm4x8(back / back_all);
}
