#version 430
// As passes/visibility/trace.comp, and the first hit of each ray: the nearest vertex about it, and its side.   [own]
// One dispatch traces the 32 directions of one word at most: loops may end silently after 65,535 iterations.
// Defines: SHEER, where cloth lets light through: the share that is left, a byte each.
#include "sight.glsl"
#include "inputs/visibility/ground_cell.glsl"
layout(local_size_x = 64) in;          // and a row of groups for each class
uniform isamplerBuffer corner_index;   // three a triangle, in the order that hits are weighted in
uniform samplerBuffer probe_data;      // two texels: position, offset of the front; N, offset of the back
uniform samplerBuffer direction_data;  // toward the light
uniform samplerBuffer vertex_data;     // three texels a vertex: position, normal, tangent
layout(std430) buffer Bits { uint bits[]; };  // of each word all probes, one after the other
layout(std430) writeonly buffer Hits { uint hits[]; };  // direction by direction: twice the vertex, 1 more for its back
uniform int first_probe[9];            // of each class, and the one after the last
uniform int probe_count;
uniform int class_directions;          // how many directions each class has
uniform int first_direction;
uniform int last_direction;            // the one after the last

uint hit_vertex(Visit visit, vec3 origin, vec3 omega) {
    if (visit.triangle == NO_TRIANGLE) return 0xffffffffu;
    if (visit.triangle == GROUND) {
        vec4 w;
        ivec4 v = ground_cell(origin + visit.t * omega, w);
        float most = max(max(w.x, w.y), max(w.z, w.w));
        return uint(2 * (most == w.x ? v.x : most == w.y ? v.y : most == w.z ? v.z : v.w));
    }
    int t = 3 * int(visit.triangle);
    ivec3 corner = ivec3(texelFetch(corner_index, t).x, texelFetch(corner_index, t + 1).x, texelFetch(corner_index, t + 2).x);
    vec3 a = texelFetch(vertex_data, 3 * corner.x).xyz;
    vec3 b = texelFetch(vertex_data, 3 * corner.y).xyz;
    vec3 c = texelFetch(vertex_data, 3 * corner.z).xyz;
    int side = dot(cross(b - a, c - a), omega) < 0.0 ? 0 : 1;
    float first = 1.0 - visit.weights.x - visit.weights.y;
    int nearest = first >= max(visit.weights.x, visit.weights.y) ? corner.x
        : visit.weights.x >= visit.weights.y ? corner.y : corner.z;
    return uint(2 * nearest + side);
}

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
        vec3 origin = x.xyz + off * N.xyz;
        Visit first;
        uint share = uint(int(255.0 * seen_along(origin, omega, first) + 0.5));
        int at = (d >> 2) * probe_count + i, place = 8 * (d & 3);
        bits[at] = bits[at] & ~(0xffu << uint(place)) | share << uint(place);
        hits[d * probe_count + i] = hit_vertex(first, origin, omega);
    } while (++d < last_direction);
#else
    int at = (first_direction >> 5) * probe_count + i;
    int count = last_direction - first_direction;
    uint mine = (count == 32 ? 0u : 1u << uint(count)) - 1u;
    uint word = bits[at] & ~(mine << uint(first_direction & 31));
    int d = first_direction;
    do {
        vec3 omega = texelFetch(direction_data, direction_base + d).xyz;
        float off = dot(omega, N.xyz) < 0.0 ? -N.w : x.w;
        vec3 origin = x.xyz + off * N.xyz;
        Visit visit = Visit(3e38, NO_TRIANGLE, vec2(0.0));
        traverse(make_ray(origin, omega, 0.0, 3e38), visit);
        if (visit.triangle == NO_TRIANGLE) word |= 1u << uint(d & 31);
        hits[d * probe_count + i] = hit_vertex(visit, origin, omega);
    } while (++d < last_direction);
    bits[at] = word;
#endif
}
