#version 430
// What the probes of one class see of the broad light, in the parts of their surface frame: seen, and all there is.   [own]
// No rays: this runs whenever the lights change or turn. Twin: glcloth/reference/visibility.py broad_sums
#include "trace/visibility.glsl"
layout(local_size_x = 64) in;
layout(binding = 9) uniform usamplerBuffer bit_data;    // passes/visibility_trace.comp
layout(binding = 10) uniform samplerBuffer light_data;  // of the directions: D_j, how much light comes from there
layout(binding = 11) uniform samplerBuffer probe_data;
layout(binding = 12) uniform samplerBuffer x_data;      // yarn 1 at the probes, and the handedness
layout(std430, binding = 0) writeonly buffer Sums { uint sums[]; };  // as in passes/visibility_mean.comp
uniform int first_item;  // probe
uniform int last_item;   // the one after the last
uniform int probe_count;
uniform int group;       // of the first four numbers
uniform int group_count;
uniform int first_direction;  // in light_data
uniform int direction_count;

void store(int at, vec4 seen, vec4 all) {
    sums[at] = packHalf2x16(vec2(seen.x, all.x));
    sums[at + 1] = packHalf2x16(vec2(seen.y, all.y));
    sums[at + 2] = packHalf2x16(vec2(seen.z, all.z));
    sums[at + 3] = packHalf2x16(vec2(seen.w, all.w));
}

void main() {
    int i = first_item + int(gl_GlobalInvocationID.x);
    if (i >= last_item) return;
    vec3 N = texelFetch(probe_data, 2 * i + 1).xyz;
    vec4 x = texelFetch(x_data, i);
    vec3 y = x.w * cross(N, x.xyz);
    int side = 0;
    do {
        vec4 low = vec4(0.0), low_all = low, middle = low, middle_all = low;
        vec2 top = vec2(0.0);
        int d = 0;
        do {
            vec4 light = texelFetch(light_data, first_direction + d);
            vec3 omega = vec3(dot(light.xyz, x.xyz), dot(light.xyz, y), dot(light.xyz, side == 0 ? N : -N));
            // The low band tells the horizon apart: here less of it counts than in the means of the Gaussians.
            float w = light.w * clamp(8.0 * omega.z, 0.0, 1.0);
            float seen = float(texelFetch(bit_data, (d >> 5) * probe_count + i).x >> uint(d & 31) & 1u);
            vec3 bands = band_shares(omega.z);
            vec4 quadrants = quadrant_shares(omega);
            // Squares: each mean is of the middle of its part, for values are laid straight between them.
            bands *= bands * w;
            quadrants *= quadrants;
            low_all += bands.x * quadrants;
            low += bands.x * seen * quadrants;
            middle_all += bands.y * quadrants;
            middle += bands.y * seen * quadrants;
            top += bands.z * vec2(seen, 1.0);
        } while (++d < direction_count);
        int at = 8 * i * group_count + 4 * (side * group_count + group);
        store(at, low, low_all);
        store(at + 4, middle, middle_all);
        store(at + 8, vec4(top.x), vec4(top.y));
    } while (++side < 2);
}
