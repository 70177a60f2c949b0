#version 430
// The broad light at the probes, in the parts of their surface frame: the seen part, and the whole.   [own]
// No rays: this runs whenever the lights change or turn. Twin: glcloth/twins/visibility.py broad_sums
#include "trace/visibility.glsl"
layout(local_size_x = 64) in;      // and a row of groups for each class
uniform usamplerBuffer bit_data;   // passes/visibility/trace.comp
uniform samplerBuffer light_data;  // of the directions: D_j, how much light comes from there
uniform samplerBuffer probe_data;
uniform samplerBuffer x_data;      // yarn 1 at the probes, and the handedness
layout(std430) buffer Sums { uvec4 sums[]; };  // as in passes/visibility/mean.comp
uniform int first_probe[9];        // of each class, and the one after the last
uniform int probe_count;
uniform int group;                 // of the low band; the middle one follows
uniform int top_number;            // where the top's sums lie among the Gaussians'
uniform int group_count;
uniform int share;                 // how many directions of light_data each class has,
uniform int direction_count;       // and how many of them are traced

void main() {
    int i = first_probe[gl_WorkGroupID.y] + int(gl_GlobalInvocationID.x);
    if (i >= first_probe[gl_WorkGroupID.y + 1u]) return;
    vec3 N = texelFetch(probe_data, 2 * i + 1).xyz;
    vec4 x = texelFetch(x_data, i);
    vec3 y = x.w * cross(N, x.xyz);
    int first = share * int(gl_WorkGroupID.y);
    vec4 low = vec4(0.0), low_all = low, middle = low, middle_all = low;  // front
    vec4 low_back = low, low_all_back = low, middle_back = low, middle_all_back = low;
    vec4 top = low;  // front: the seen part, and the whole; back
    int d = 0;
    do {
        vec4 light = texelFetch(light_data, first + d);
        vec3 omega = vec3(dot(light.xyz, x.xyz), dot(light.xyz, y), dot(light.xyz, N));
#ifdef SHEER
        float seen = float(int(texelFetch(bit_data, (d >> 2) * probe_count + i).x >> uint(8 * (d & 3)) & 0xffu)) / 255.0;
#else
        float seen = float(int(texelFetch(bit_data, (d >> 5) * probe_count + i).x >> uint(d & 31) & 1u));
#endif
        vec2 side = omega.z > 0.0 ? vec2(1.0, 0.0) : vec2(0.0, 1.0);
        float z = abs(omega.z);
        vec3 bands = band_shares(z);
        vec4 quadrants = quadrant_shares(omega);
        // Squares: each mean is of the middle of its part, for values are laid straight between them. The low band tells
        // the horizon apart: here less of it counts than in the means of the Gaussians.
        bands *= bands * (light.w * min(8.0 * z, 1.0));
        quadrants *= quadrants;
        vec4 low_part = bands.x * quadrants, middle_part = bands.y * quadrants;
        low_all += side.x * low_part;
        middle_all += side.x * middle_part;
        low_all_back += side.y * low_part;
        middle_all_back += side.y * middle_part;
        top.yw += side * bands.z;
        side *= seen;
        low += side.x * low_part;
        middle += side.x * middle_part;
        low_back += side.y * low_part;
        middle_back += side.y * middle_part;
        top.xz += side * bands.z;
    } while (++d < direction_count);
    int at = 2 * i * group_count;
    sums[at + group] = packed_sums(low, low_all);
    sums[at + group + 1] = packed_sums(middle, middle_all);
    sums[at + (top_number >> 2)][top_number & 3] = packed_sums(top.xxxx, top.yyyy).x;
    at += group_count;
    sums[at + group] = packed_sums(low_back, low_all_back);
    sums[at + group + 1] = packed_sums(middle_back, middle_all_back);
    sums[at + (top_number >> 2)][top_number & 3] = packed_sums(top.zzzz, top.wwww).x;
}
