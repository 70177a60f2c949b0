// Method `direct`: quadrature at nodes that are shared by all tangents and all lobes; nothing of the fabric is precomputed but
// what glsl/passes/methods/view_table.comp makes of it whenever it changes.   [own]
//   L_o = sum_k L_k sum_n w_n sum_t R_t(omega_n) cos(theta_i) (f_rs + A_j f_rv)
// Defines: those of inputs/methods/direct_tangents.glsl; POOLED(L), L or nothing. See docs/direct.md.
#include "direct/node.glsl"
#include "direct/view.glsl"
#include "inputs/methods/direct_tangents.glsl"
#include "trace/octahedron.glsl"
#include "seen.glsl"
#if defined(WEAVE) || defined(TERMS)
uniform vec4 slot_low[GROUPS], slot_high[GROUPS];  // share of each tangent in the tables of negative and of positive tilts
#endif
#include "inputs/methods/threads.glsl"

// glcloth/methods/direct reads these numbers here.
const int NODE_COLUMNS = 64;
const int ENTRY_TEXELS = 8;
const float MAP_SIZE = 160.0;

uniform samplerBuffer node_data;   // rows of NODE_COLUMNS: (a, b, c, share); after each rule its mean, with what the horizon takes of the variance for a
uniform samplerBuffer entry_data;  // ENTRY_TEXELS for each Gaussian and rule, or sun
uniform sampler2D pooled_light;   // radiance of the pooled Gaussians, world, octahedral
uniform sampler2D broad_light;    // radiance of the broadest Gaussians, likewise
uniform sampler2DArray view_table;  // omega_o as a disk; a layer for each direction of broad light
uniform float view_rim;  // of that disk
uniform ivec2 entry_counts;  // those of several nodes come first; all. The one behind them weighs nothing and is lit everywhere
uniform ivec2 broad_nodes;   // the first of those directions in node_data, and their number

// The radiance of a map in a direction of world space.
vec3 map_radiance(sampler2D map, vec3 omega) {
    // Texel centres on the rim of the square: there it is folded, and both sides hold the same value.
    return textureLod(map, 0.5 + (0.5 - 0.5 / MAP_SIZE) * octahedral(omega), 0.0).rgb;
}

// -- Gaussians at their own nodes ---------------------------------------------------------------------------------------

vec4 fetch_node(int row, int column, float between) {
    int at = row * NODE_COLUMNS + column;
    vec4 a = texelFetch(node_data, at), b = texelFetch(node_data, at + 1);
    return a + between * (b - a);
}

// The next entry whose light reaches a surface of normal N. Pixels side by side may each be at another one: that is what
// makes it worth while where lanes run in step, as an `if` would not.
int entry_after(int k, vec3 N) {
    vec4 head;
    do {
        head = texelFetch(entry_data, ++k * ENTRY_TEXELS);
    } while (dot(head.xyz, N) < head.w);
    return k;
}

struct Entry {
    vec3 light;    // radiance of the axis
    int V;         // number of its V
    int node;      // first row of its rule,
    int last;      // and the row of its mean
    vec3 xi;       // axis, surface frame
    vec2 e;        // its azimuth
    int column;    // of node_data
    float between;
};

Entry fetch_entry(int k, mat3 surface_from_world) {
    int at = k * ENTRY_TEXELS;
    vec4 head = texelFetch(entry_data, at);       // xi in world space; the least xi . N that counts
    vec4 light = texelFetch(entry_data, at + 1);  // radiance; number of its V, first row of its rule, rows
    entry_kept = texelFetch(entry_data, at + 2);
    entry_sharp = entry_spread = texelFetch(entry_data, at + 3);  // of one node, of several
    entry_amplitude = texelFetch(entry_data, at + 4);
    float width = texelFetch(entry_data, at + 5).x;  // of its columns
    int rows = floatBitsToInt(light.w);
    vec3 xi = surface_from_world * head.xyz;
    float place = column_of(atan(length(xi.xy), xi.z), width) * float(NODE_COLUMNS - 1);
    int column = min(int(place), NODE_COLUMNS - 2);
    int node = rows >> 8 & 0xffff;
    return Entry(light.rgb, rows >> 24, node, node + (rows & 255), xi, azimuth(xi), column, place - float(column));
}

vec3 node_direction(Entry entry, vec3 node) {
    vec3 omega_i = direction_from_node(node, entry.xi, entry.e);
    return vec3(omega_i.xy, max(omega_i.z, 0.0));
}

void light_at(vec3 omega_i, float share, float cos_o) {
    set_omega_i(omega_i);
    Q = gap * cos_o + 1e-20;
    EACH_GROUP(add_P)
    float weight = share / Q;
#define LIGHT(g) light_group(g, omega_i, weight)
    EACH_GROUP(LIGHT)
}

vec3 L_shared(float cos_o, mat3 surface_from_world) {
    vec3 L = vec3(0.0);
    vec3 N = vec3(surface_from_world[0].z, surface_from_world[1].z, surface_from_world[2].z);
    int k = entry_after(-1, N);
    // Do loops: llvmpipe runs the body of a while loop once more than it is wanted.
    if (k < entry_counts.x) do {
        Entry entry = fetch_entry(k, surface_from_world);
        vec4 mean = fetch_node(entry.last, entry.column, entry.between);
        vec3 omega_mean = node_direction(entry, vec3(0.0, mean.yz));
        entry_kept_cut = texelFetch(entry_data, k * ENTRY_TEXELS + 6);
        entry_spread_cut = texelFetch(entry_data, k * ENTRY_TEXELS + 7);
        entry_cut = mean.x;
        entry_u = vec2(-entry.e.y, entry.e.x);
        entry_v = vec3(entry.xi.z * entry.e, -dot(entry.xi.xy, entry.e));
#define AIM(g) aim_group(g, omega_mean)
        EACH_GROUP(AIM)
        int node = entry.node;
        do {
            vec4 rule = fetch_node(node, entry.column, entry.between);
            light_at(node_direction(entry, rule.xyz), rule.w, cos_o);
        } while (++node < entry.last);
        ADD_LIGHT(entry.light * (exp(mean.w) * V_number(entry.V)), entry.xi);
        k = entry_after(k, N);
    } while (k < entry_counts.x);
    // Rules of one node, which is the mean.
    do {
        Entry entry = fetch_entry(k, surface_from_world);
        vec4 mean = fetch_node(entry.last, entry.column, entry.between);
        EACH_GROUP(aim_group_at_node)
        light_at(node_direction(entry, vec3(0.0, mean.yz)), 1.0, cos_o);
        ADD_LIGHT(entry.light * (exp(mean.w) * V_number(entry.V)), entry.xi);
        k = entry_after(k, N);
    } while (k < entry_counts.y);
    return L;
}

// -- the broadest Gaussians together, as they are at a few directions -----------------------------------------------------

vec3 L_broad(vec3 omega_o, mat3 surface_from_world) {
    vec3 L = vec3(0.0);
    vec2 place = 0.5 + (0.5 - 0.5 / float(textureSize(view_table, 0).x)) * to_view(omega_o, view_rim);
#ifdef WEAVE
    // Terms that are not of one tangent but of those of like tilt, by what is seen of these.
    vec4 low = vec4(0.0), middle = vec4(0.0), high = vec4(0.0);  // of warp and weft, then of their turns
    for (int g = 0; g < GROUPS; ++g) {
        vec4 weft = slot_yarn[g] * slot_share[g], warp = slot_share[g] - weft;
        mat4 w = mat4(rel[g] * warp, rel[g] * weft, turn[g] * warp, turn[g] * weft);
        low += slot_low[g] * w;
        high += slot_high[g] * w;
        middle += (1.0 - slot_low[g] - slot_high[g]) * w;
    }
#endif
#ifdef TERMS
    begin_broad();
#endif
    int j = 0;
    do {
        vec3 omega = texelFetch(node_data, broad_nodes.x + j).xyz;
#ifdef WEAVE
        vec2 side = lean(omega);
        vec3 f = COLORED(textureLod(view_table, vec3(place, float(j)), 0.0) * (low.xy + side * low.zw).xxyy
            + textureLod(view_table, vec3(place, float(j + broad_nodes.y)), 0.0) * (middle.xy + side * middle.zw).xxyy
            + textureLod(view_table, vec3(place, float(j + 2 * broad_nodes.y)), 0.0) * (high.xy + side * high.zw).xxyy);
#endif
#ifdef TERMS
        vec3 light = map_radiance(broad_light, omega * surface_from_world) * V_broad(omega);
        add_broad(light, omega, textureLod(view_table, vec3(place, float(j)), 0.0),
            textureLod(view_table, vec3(place, float(j + broad_nodes.y)), 0.0),
            textureLod(view_table, vec3(place, float(j + 2 * broad_nodes.y)), 0.0));
#else
#ifndef WEAVE
        vec3 f = textureLod(view_table, vec3(place, float(j)), 0.0).rgb;
#endif
        L += f * map_radiance(broad_light, omega * surface_from_world) * V_broad(omega);
#endif
    } while (++j < broad_nodes.y);
#ifdef TERMS
    end_broad();
#endif
    return L;
}

// -- broad Gaussians together, at the nodes of narrow lobes -------------------------------------------------------------

mat3 world;  // surface_from_world
vec3 L_pooled;

void add_node(vec3 omega, SUMS weight) {
#ifdef TERMS
    add_pooled(map_radiance(pooled_light, omega * world) * V_broad(omega), omega, weight);
#else
    L_pooled += COLORED(weight) * map_radiance(pooled_light, omega * world) * V_broad(omega);
#endif
}
#include "inputs/methods/direct_lobes.glsl"

vec3 L_o(vec3 omega_o, mat3 surface_from_world) {
    set_omega_o(omega_o);
    world = surface_from_world;
    L_pooled = vec3(0.0);
#ifdef TERMS
    begin_terms();
    POOLED(visit_lobes(omega_o);)
    L_shared(omega_o.z, surface_from_world);
    L_broad(omega_o, surface_from_world);
    return end_terms();
#endif
    POOLED(visit_lobes(omega_o);)
    return L_shared(omega_o.z, surface_from_world) + L_broad(omega_o, surface_from_world) + L_pooled;
}
