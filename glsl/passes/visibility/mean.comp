#version 430
// Visibility from the probes, summed with the weights of four Gaussians; and the weights.   [own]
// No rays: this runs whenever the lights change or turn. Twin: glcloth/twins/visibility.py mean_visibility
#include "trace/visibility.glsl"
layout(local_size_x = 64) in;       // and a row of groups for each class, a layer for each four Gaussians
uniform usamplerBuffer bit_data;    // passes/visibility/trace.comp
uniform samplerBuffer entry_data;   // directions that count for the four: D_j, j; their G_kj
uniform samplerBuffer probe_data;
uniform isamplerBuffer range_data;  // of a class and four: first entry, the one after the last
layout(std430) writeonly buffer Sums { uvec4 sums[]; };  // packed_sums of a probe, front and back
uniform int first_probe[9];         // of each class, and the one after the last
uniform int probe_count;
uniform int group_count;
uniform float steepness;            // of the weight of directions: 8 for cloth, 1 is the cosine

void main() {
    int i = first_probe[gl_WorkGroupID.y] + int(gl_GlobalInvocationID.x);
    if (i >= first_probe[gl_WorkGroupID.y + 1u]) return;
    vec3 N = steepness * texelFetch(probe_data, 2 * i + 1).xyz;
    ivec2 range = texelFetch(range_data, int(gl_WorkGroupID.y * gl_NumWorkGroups.z + gl_WorkGroupID.z)).xy;
    vec4 front = vec4(0.0), front_all = front, back = front, back_all = front;
    for (int e = range.x; e < range.y; ++e) {
        vec4 direction = texelFetch(entry_data, 2 * e), G = texelFetch(entry_data, 2 * e + 1);
        int d = int(direction.w);
#ifdef SHEER
        float seen = float(int(texelFetch(bit_data, (d >> 2) * probe_count + i).x >> uint(8 * (d & 3)) & 0xffu)) / 255.0;
#else
        float seen = float(int(texelFetch(bit_data, (d >> 5) * probe_count + i).x >> uint(d & 31) & 1u));
#endif
        float cos_theta = dot(direction.xyz, N);
        vec2 w = clamp(vec2(cos_theta, -cos_theta), 0.0, 1.0);
        front_all += w.x * G;
        back_all += w.y * G;
        w *= seen;
        front += w.x * G;
        back += w.y * G;
    }
    int at = 2 * i * group_count + int(gl_WorkGroupID.z);
    sums[at] = packed_sums(front, front_all);
    sums[at + group_count] = packed_sums(back, back_all);
}
