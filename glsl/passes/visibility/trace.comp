#version 430
// Which of their class's directions of the world the probes see: a bit each, for both sides of the sheet.   [own]
// One dispatch traces the 32 directions of one word at most: loops may end silently after 65,535 iterations.
// Defines: SHEER, where cloth lets light through: the share that is left, a byte each.
#include "sight.glsl"
layout(local_size_x = 64) in;          // and a row of groups for each class
uniform samplerBuffer probe_data;      // two texels: position, offset of the front; N, offset of the back
uniform samplerBuffer direction_data;  // toward the light
layout(std430) buffer Bits { uint bits[]; };  // of each word all probes, one after the other
uniform int first_probe[9];            // of each class, and the one after the last
uniform int probe_count;
uniform int class_directions;          // how many directions each class has
uniform int first_direction;
uniform int last_direction;            // the one after the last

void main() {
    int i = first_probe[gl_WorkGroupID.y] + int(gl_GlobalInvocationID.x);
    if (i >= first_probe[gl_WorkGroupID.y + 1u]) return;
    int direction_base = class_directions * int(gl_WorkGroupID.y);
    vec4 x = texelFetch(probe_data, 2 * i);
    vec4 N = texelFetch(probe_data, 2 * i + 1);
#ifdef SHEER
    int d = first_direction;
    do {
        vec3 omega = texelFetch(direction_data, direction_base + d).xyz;
        float off = dot(omega, N.xyz) < 0.0 ? -N.w : x.w;
        Visit first;
        uint share = uint(int(255.0 * seen_along(x.xyz + off * N.xyz, omega, first) + 0.5));
        int at = (d >> 2) * probe_count + i, place = 8 * (d & 3);
        bits[at] = bits[at] & ~(0xffu << uint(place)) | share << uint(place);
    } while (++d < last_direction);
#else
    int at = (first_direction >> 5) * probe_count + i;
    int count = last_direction - first_direction;
    uint mine = (count == 32 ? 0u : 1u << uint(count)) - 1u;
    uint word = bits[at] & ~(mine << uint(first_direction & 31));
    int d = first_direction;
    do {
        vec3 omega = texelFetch(direction_data, direction_base + d).xyz;
        // Off the side by which the ray leaves.
        float off = dot(omega, N.xyz) < 0.0 ? -N.w : x.w;
        Visit visit = Visit(3e38, NO_TRIANGLE, vec2(0.0));
        Ray ray = make_ray(x.xyz + off * N.xyz, omega, 0.0, 3e38);
        traverse(ray, visit);
        if (visit.t > 0.0) word |= 1u << uint(d & 31);
    } while (++d < last_direction);
    bits[at] = word;
#endif
}
