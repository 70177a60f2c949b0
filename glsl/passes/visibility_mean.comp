#version 430
// What the probes of one class see, summed with the weights of four Gaussians; and the weights.   [own]
// No rays: this runs whenever the lights change or turn. Twin: glcloth/reference/visibility.py mean_visibility
layout(local_size_x = 64) in;
layout(binding = 9) uniform usamplerBuffer bit_data;     // passes/visibility_trace.comp
layout(binding = 10) uniform samplerBuffer entry_data;   // what counts for a Gaussian: D_j, j + G_kj / 2
layout(binding = 11) uniform samplerBuffer probe_data;
layout(std430, binding = 0) writeonly buffer Sums { uint sums[]; };  // half x 2 (seen, all): of a probe front and back
uniform int first_item;  // probe
uniform int last_item;   // the one after the last
uniform int probe_count;
uniform int group;
uniform int group_count;
uniform ivec4 first;     // entry of each of the four Gaussians
uniform ivec4 last;      // the one after its last
uniform float steepness;  // of the weight of directions: 8 for cloth, 1 is the cosine

void main() {
    int i = first_item + int(gl_GlobalInvocationID.x);
    if (i >= last_item) return;
    vec3 N = steepness * texelFetch(probe_data, 2 * i + 1).xyz;
    ivec4 begin = first, end = last;
    int at = 8 * i * group_count + 4 * group;
    int n = 0;
    do {
        vec4 sum = vec4(0.0);  // front and back: what is seen, and all
        for (int e = begin.x; e < end.x; ++e) {
            vec4 entry = texelFetch(entry_data, e);
            float number = floor(entry.w), G = entry.w - number;
            int d = int(number);
            uint word = texelFetch(bit_data, (d >> 5) * probe_count + i).x;
            float cos_theta = dot(entry.xyz, N);
            vec2 w = G * clamp(vec2(cos_theta, -cos_theta), 0.0, 1.0);
            sum += vec4((word >> uint(d & 31) & 1u) != 0u ? w : vec2(0.0), w);
        }
        sums[at + n] = packHalf2x16(sum.xz);
        sums[at + 4 * group_count + n] = packHalf2x16(sum.yw);
        begin = begin.yzwx;
        end = end.yzwx;
    } while (++n < 4);
}
