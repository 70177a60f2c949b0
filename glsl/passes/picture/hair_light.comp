#version 430
// What hairs of each direction show of each light, under no shadow: for warp and weft the surface and the volume term, for
// the colour 1.   [own]
// The view is along z; a hair's direction and its opposite are one, so they are the hemisphere, as a disk.
#include "core/disk.glsl"
#include "fibre/scatter.glsl"
layout(local_size_x = 64) in;
#include "inputs/gpu/item.glsl"
uniform samplerBuffer light_nodes;  // of each light `node_count` directions, of the view's frame, evenly weighed
uniform int node_count;
uniform int light_count;
uniform int side;
uniform vec4 optics[2];             // of the yarns: eta, k_d, gamma_s, gamma_v
layout(rgba16f) writeonly uniform image2DArray hair_table;

void main() {
    int i = item();
    if (i >= side * side * light_count) return;
    ivec3 texel = ivec3(i % side, i / side % side, i / (side * side));
    vec3 t = from_disk(2.0 * vec2(texel.xy) / float(side - 1) - 1.0);
    vec3 b = normalize(abs(t.z) < 0.9 ? vec3(-t.y, t.x, 0.0) : vec3(0.0, -t.z, t.y)), n = cross(t, b);
    vec3 omega_o = vec3(t.z, b.z, n.z);
    vec4 sum = vec4(0.0);
    int node = 0;
    do {
        vec3 d = texelFetch(light_nodes, texel.z * node_count + node).xyz;
        vec3 omega_i = vec3(dot(d, t), dot(d, b), dot(d, n));
        float cos_theta_i = length(omega_i.yz);
        sum += cos_theta_i * vec4(f_s(omega_i, omega_o, optics[0].x, optics[0].y, optics[0].z, optics[0].w),
            f_s(omega_i, omega_o, optics[1].x, optics[1].y, optics[1].z, optics[1].w));
    } while (++node < node_count);
    imageStore(hair_table, texel, sum / float(node_count));
}
