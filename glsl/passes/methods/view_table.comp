#version 430
// Radiance of cloth toward omega_o from light at a few directions x_j: c_j = int f cos(theta_i) B_j, for method
// `direct`; omega_o over the disk, B_j the share of x_j in light from between (glcloth/methods/direct/broad_nodes.py).   [own]
// Its place in z is a block of 16 directions.
#include "core/disk.glsl"
#include "direct/view.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
uniform sampler2DArray basis_map;   // B over the hemisphere as a disk, four a layer
uniform samplerBuffer fixed_nodes;  // a rule over the hemisphere: directions; then B times weights, four a texel
layout(rgba32f) writeonly uniform image2DArray view_table;
uniform int fixed_count;
uniform float view_rim;
uniform int block_count;
uniform vec4 broad_kept, broad_spread, broad_amplitude;  // as entry_kept, ...

uniform int first_layer;
#ifdef WEAVE
#define TABLE mat4
#define SUMS vec4
#define TEXEL(c) c
uniform vec4 table_rel[GROUPS];  // which tangents, how much
#else
#define TABLE mat4x3
#define SUMS vec3
#define TEXEL(c) vec4(c, 0.0)
#endif
TABLE c_0, c_1, c_2, c_3;  // of the block's directions
int block;

void add(SUMS weight, vec4 b_0, vec4 b_1, vec4 b_2, vec4 b_3) {
    c_0 += outerProduct(weight, b_0);
    c_1 += outerProduct(weight, b_1);
    c_2 += outerProduct(weight, b_2);
    c_3 += outerProduct(weight, b_3);
}

vec4 basis(vec2 place, int i) { return textureLod(basis_map, vec3(place, float(4 * block + i)), 0.0); }

void add_node(vec3 omega, SUMS weight) {
    float size = float(textureSize(basis_map, 0).x);
    vec2 place = 0.5 + (0.5 - 0.5 / size) * to_disk(omega);
    add(weight, basis(place, 0), basis(place, 1), basis(place, 2), basis(place, 3));
}
#include "inputs/methods/direct_lobes.glsl"

// The isotropic share, and the lobes that have no nodes of their own.
void visit_fixed(float cos_o) {
    entry_kept = broad_kept;
    entry_spread = broad_spread;
    entry_amplitude = broad_amplitude;
    entry_kept_cut = entry_spread_cut = vec4(0.0);
    entry_cut = 0.0;
    entry_v = vec3(0.0);
    entry_u = vec2(0.0);
    vec3 up = vec3(0.0, 0.0, 1.0);
#define AIM_UP(g) aim_group(g, up)
#define CLEAR(g) surface[g] = volume[g] = vec4(0.0)
    EACH_GROUP(AIM_UP)
    int n = 0;
    do {
        vec3 omega = texelFetch(fixed_nodes, n).xyz;
        set_omega_i(omega);
        Q = gap * cos_o + 1e-20;
        EACH_GROUP(add_P)
        float weight = 1.0 / Q;
#define LIGHT_FIXED(g) light_group(g, omega, weight)
        EACH_GROUP(CLEAR)
        EACH_GROUP(LIGHT_FIXED)
        int at = fixed_count + 4 * (n * block_count + block);
        add(sum_tangents(vec2(0.0)), texelFetch(fixed_nodes, at), texelFetch(fixed_nodes, at + 1), texelFetch(fixed_nodes, at + 2),
            texelFetch(fixed_nodes, at + 3));
    } while (++n < fixed_count);
}

void main() {
    ivec3 at = ivec3(gl_GlobalInvocationID);
    ivec2 size = imageSize(view_table).xy;
    if (any(greaterThanEqual(at.xy, size))) return;
    vec2 p = 2.0 * vec2(at.xy) / vec2(size - 1) - 1.0;
    // Two texels beyond the horizon nothing is read.
    if (length(p) > 1.0 + 4.0 / float(size.x - 1)) return;
    block = at.z;
    vec3 omega_o = from_view(p, view_rim);
    omega_o = normalize(vec3(omega_o.xy, max(omega_o.z, 1e-3)));
    c_0 = c_1 = c_2 = c_3 = TABLE(0.0);
#ifdef WEAVE
#define SET_REL(g) rel[g] = table_rel[g], turn[g] = vec4(0.0)
    EACH_GROUP(SET_REL)
#endif
    set_omega_o(omega_o);
    visit_fixed(omega_o.z);
    visit_lobes(omega_o);
    for (int i = 0; i < 4; ++i) {
        imageStore(view_table, ivec3(at.xy, first_layer + 16 * block + i), TEXEL(c_0[i]));
        imageStore(view_table, ivec3(at.xy, first_layer + 16 * block + 4 + i), TEXEL(c_1[i]));
        imageStore(view_table, ivec3(at.xy, first_layer + 16 * block + 8 + i), TEXEL(c_2[i]));
        imageStore(view_table, ivec3(at.xy, first_layer + 16 * block + 12 + i), TEXEL(c_3[i]));
    }
}
