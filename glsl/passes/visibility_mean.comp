#version 430
// Means of what the probes see, weighted by four Gaussians: V_k of both sides from the bits.   [own]
// No rays: this runs whenever the lights change or turn. Twin: glcloth/reference/visibility.py mean_visibility
layout(local_size_x = 64) in;
layout(binding = 9) uniform usamplerBuffer bit_data;         // passes/visibility_trace.comp
layout(binding = 10) uniform samplerBuffer entry_data;       // what counts for a Gaussian: D_j, j + G_kj / 2
layout(binding = 11) uniform samplerBuffer probe_data;
layout(std430, binding = 0) writeonly buffer Means { uint means[]; };  // unorm8 x 4: of a probe front and back, of a side the groups
uniform int probe_count;
uniform int group;
uniform int group_count;
uniform ivec4 first;  // entry of each of the four Gaussians
uniform ivec4 last;   // the one after its last
uniform vec4 least;   // with so little in sight the Gaussian lights the other side

void main() {
    int i = int(gl_GlobalInvocationID.x);
    if (i >= probe_count) return;
    vec3 N = 8.0 * texelFetch(probe_data, 2 * i + 1).xyz;
    vec4 front = vec4(0.0), back = vec4(0.0);
    ivec4 begin = first, end = last;
    vec4 limit = least;
    int n = 0;
    do {
        vec4 sums = vec4(0.0);  // front and back, what is seen and all
        for (int e = begin.x; e < end.x; ++e) {
            vec4 entry = texelFetch(entry_data, e);
            float number = floor(entry.w), G = entry.w - number;
            int d = int(number);
            uint word = texelFetch(bit_data, (d >> 5) * probe_count + i).x;
            float cos_theta = dot(entry.xyz, N), w = clamp(cos_theta, 0.0, 1.0) * G;
            float w_back = clamp(-cos_theta, 0.0, 1.0) * G;
            vec4 both = vec4(w, w_back, w, w_back);
            both.xy = (word >> uint(d & 31) & 1u) != 0u ? both.xy : vec2(0.0);
            sums += both;
        }
        vec2 V = (sums.xy + 0.5 * limit.x) / max(sums.zw + 0.5 * limit.x, vec2(1e-20));
        front = vec4(front.yzw, V.x);
        back = vec4(back.yzw, V.y);
        begin = begin.yzwx;
        end = end.yzwx;
        limit = limit.yzwx;
    } while (++n < 4);
    means[2 * i * group_count + group] = packUnorm4x8(front);
    means[(2 * i + 1) * group_count + group] = packUnorm4x8(back);
}
