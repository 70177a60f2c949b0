#version 430
// From probes to the vertices between them: a weighted mean of at most four.   [own]
layout(local_size_x = 64) in;
layout(binding = 9) uniform usamplerBuffer mean_data;     // passes/visibility_mean.comp
layout(binding = 10) uniform usamplerBuffer between_data;  // of a vertex four probes, then their weights as floats
layout(std430, binding = 0) writeonly buffer Means { uint means[]; };
uniform int vertex_count;
uniform int words;  // of a probe and of a vertex

void main() {
    int i = int(gl_GlobalInvocationID.x);
    if (i >= vertex_count) return;
    ivec4 probe = ivec4(texelFetch(between_data, 2 * i)) * words;
    vec4 weight = uintBitsToFloat(texelFetch(between_data, 2 * i + 1));
    int n = 0;
    do {
        means[i * words + n] = packUnorm4x8(weight.x * unpackUnorm4x8(texelFetch(mean_data, probe.x + n).x)
            + weight.y * unpackUnorm4x8(texelFetch(mean_data, probe.y + n).x)
            + weight.z * unpackUnorm4x8(texelFetch(mean_data, probe.z + n).x)
            + weight.w * unpackUnorm4x8(texelFetch(mean_data, probe.w + n).x));
    } while (++n < words);
}
