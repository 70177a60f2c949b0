// The tangents of a fabric at one omega_o, and their terms at one omega_i, for the passes of method `direct`.   [Miz 4-6]
//   sum_t R_t cos(theta_i) (f_rs + A_j f_rv),   R_t = w_t M_t P_t / Q
// Defines: GROUPS, vec4s that hold the tangents; EACH_GROUP(F), that is F(0); F(1); ... F(GROUPS - 1); LANES(g), 1 for each
// component of those vec4s that is in use; WEAVE and LANE_COUNT, their number, where a pixel sees `rel` of each. See docs/direct.md.
#include "core/math.glsl"
#include "direct/slots.glsl"
#include "inputs/methods/rel.glsl"

uniform vec4 mask_series;               // of g_of_cos, for sigma of shadowing and masking
uniform float gap;                      // 1 - a_1 - a_2 in W's normaliser
uniform vec3 yarn_A[2];
// Four tangents each; unused ones weigh nothing. A LANES(g) of 0 is a constant that lets the compiler drop a component.
uniform vec4 slot_cos_tilt[GROUPS];
uniform vec4 slot_sin_tilt[GROUPS];
uniform vec4 slot_share[GROUPS];  // in W's normaliser
uniform vec4 slot_yarn[GROUPS];  // 0 or 1
uniform vec4 slot_F_0[GROUPS];
uniform vec4 slot_k_d[GROUPS];
// The factor in the sum over that in W's normaliser, and the numbers that `light_group` leaves out.
uniform vec4 slot_surface[GROUPS], slot_volume_0[GROUPS], slot_volume_1[GROUPS];

// What omega_o fixes. On llvmpipe arrays with constant indices are registers.
vec2 sin_psi_o, cos_psi_o;  // of the two yarns, for tilt 0
vec4 sin_theta_o[GROUPS], cos_theta_o[GROUPS], theta_o[GROUPS];
vec4 cos_phi_o[GROUPS], sin_phi_o[GROUPS], cos_psi_t[GROUPS];
vec4 shared_P[GROUPS], surface[GROUPS], volume[GROUPS];

vec4 of_yarn(int g, vec2 yarns) {
    return mix(vec4(yarns.x), vec4(yarns.y), greaterThan(slot_yarn[g], vec4(0.5)));
}

void set_omega_o_group(int g, vec3 omega_o) {
    vec4 along = of_yarn(g, omega_o.xy), across = of_yarn(g, vec2(omega_o.y, -omega_o.x));
    mat2x4 o = tangent_slots(along, omega_o.z, slot_cos_tilt[g], slot_sin_tilt[g]);
    vec4 c2 = max(1.0 - o[0] * o[0], 1e-7);
    vec4 inv = inversesqrt(c2);
    sin_theta_o[g] = o[0];
    cos_theta_o[g] = c2 * inv;
    theta_o[g] = theta_slots(o[0]);
    cos_phi_o[g] = o[1] * inv;
    sin_phi_o[g] = across * inv;
    cos_psi_t[g] = max(of_yarn(g, cos_psi_o) * slot_cos_tilt[g] + of_yarn(g, sin_psi_o) * slot_sin_tilt[g], 0.0);
}

// What depends on one direction omega_i and the yarn only.
vec2 sin_psi_i, cos_psi_i, g_psi;

void set_omega_i(vec3 omega_i) {
    vec2 inv = inversesqrt(omega_i.xy * omega_i.xy + omega_i.z * omega_i.z + 1e-20);
    sin_psi_i = omega_i.xy * inv;
    cos_psi_i = omega_i.z * inv;
    g_psi = g_of_cos(vec4(cos_psi_i * cos_psi_o + sin_psi_i * sin_psi_o, 0.0, 0.0), mask_series).xy;
}

float Q;

void add_P(int g) {
    vec4 c = max(of_yarn(g, cos_psi_i) * slot_cos_tilt[g] + of_yarn(g, sin_psi_i) * slot_sin_tilt[g], 0.0);
    shared_P[g] = slot_share[g] * LANES(g) * D_masks(of_yarn(g, g_psi), c, cos_psi_t[g]);
    Q += dot(shared_P[g], vec4(1.0));
}

// Of one entry; components (surface of yarn 0, surface of yarn 1, volume of yarn 0, volume of yarn 1): how much of its
// distance from the mean a node keeps; the widened lobe is
// amplitude exp2(-(sharp (theta_i + theta_o))^2), with `sharp` in its amplitude already where a rule has one node.
vec4 entry_kept, entry_sharp, entry_amplitude;
// The same of several nodes of a Gaussian that the horizon cuts: 1 / sharp^2, and what it and `kept` change by for each
// unit of variance that a tangent's theta_i loses. entry_cut: the loss of the direction entry_v, which tilts the axis; the
// direction N x entry_v loses none.
vec4 entry_spread, entry_spread_cut, entry_kept_cut;
float entry_cut;
vec3 entry_v;
vec2 entry_u;
// What is squared there, start + slope theta_i of the node; and the amplitude.
vec4 start_s[GROUPS], slope_s[GROUPS], amplitude_s[GROUPS], start_v[GROUPS], slope_v[GROUPS], amplitude_v[GROUPS];

// For several nodes about a mean.
void aim_group(int g, vec3 mean) {
    vec4 t = of_yarn(g, mean.xy) * slot_cos_tilt[g] - mean.z * slot_sin_tilt[g];
    vec4 theta_mean = twice_atan(t / (1.0 + sqrt(max(1.0 - t * t, 0.0))));
    vec4 along_v = of_yarn(g, entry_v.xy) * slot_cos_tilt[g] - entry_v.z * slot_sin_tilt[g];
    vec4 along_u = of_yarn(g, entry_u) * slot_cos_tilt[g];
    along_v *= along_v;
    vec4 cut = entry_cut * along_v / (along_v + along_u * along_u + 1e-6);
    vec4 kept_s = of_yarn(g, entry_kept.xy) + cut * of_yarn(g, entry_kept_cut.xy);
    vec4 kept_v = of_yarn(g, entry_kept.zw) + cut * of_yarn(g, entry_kept_cut.zw);
    vec4 wider_s = inversesqrt(of_yarn(g, entry_spread.xy) + cut * of_yarn(g, entry_spread_cut.xy));
    vec4 wider_v = inversesqrt(of_yarn(g, entry_spread.zw) + cut * of_yarn(g, entry_spread_cut.zw));
    start_s[g] = wider_s * (theta_o[g] + (1.0 - kept_s) * theta_mean);
    start_v[g] = wider_v * (theta_o[g] + (1.0 - kept_v) * theta_mean);
    slope_s[g] = wider_s * kept_s;
    slope_v[g] = wider_v * kept_v;
    amplitude_s[g] = of_yarn(g, entry_amplitude.xy) * wider_s;
    amplitude_v[g] = of_yarn(g, entry_amplitude.zw) * wider_v;
    surface[g] = volume[g] = vec4(0.0);
}

// For one node, which is the mean.
void aim_group_at_node(int g) {
    slope_s[g] = of_yarn(g, entry_sharp.xy);
    slope_v[g] = of_yarn(g, entry_sharp.zw);
    start_s[g] = slope_s[g] * theta_o[g];
    start_v[g] = slope_v[g] * theta_o[g];
    amplitude_s[g] = of_yarn(g, entry_amplitude.xy);
    amplitude_v[g] = of_yarn(g, entry_amplitude.zw);
    surface[g] = volume[g] = vec4(0.0);
}

// Adds the terms at one node, but for a factor 8 of the surface term and 4 of the volume term, which `sum_group` knows.
void light_group(int g, vec3 omega_i, float weight) {
    vec4 along = of_yarn(g, omega_i.xy), across = of_yarn(g, vec2(omega_i.y, -omega_i.x));
    mat2x4 i = tangent_slots(along, omega_i.z, slot_cos_tilt[g], slot_sin_tilt[g]);
    vec4 t = i[0], n = i[1];
    vec4 c2 = max(1.0 - t * t, 1e-7);
    vec4 inv = inversesqrt(c2);
    vec4 cos_theta_i = c2 * inv, cos_phi_i = n * inv;
    vec4 cos_phi_d = (n * cos_phi_o[g] + across * sin_phi_o[g]) * inv;
    mat4 f = scatter_slots(t, cos_theta_i, cos_phi_i, cos_phi_d, sin_theta_o[g], cos_theta_o[g], cos_phi_o[g], slot_F_0[g],
                           mask_series);
    vec4 cos_sum = cos_theta_i + cos_theta_o[g];
    vec4 F_r = f[1], F_t = 1.0 - F_r, half_cos_half_phi_d = f[2];
    // 1 / (cos^2(theta_d) (cos theta_i + cos theta_o)); the surface term takes the sum out again.
    vec4 front = weight * shared_P[g] * f[0] * cos_theta_i / (f[3] * cos_sum);
    vec4 theta_i = theta_slots(t);
    vec4 g_s = amplitude_s[g] * lobe_slots(theta_i, start_s[g], slope_s[g]);
    vec4 g_v = amplitude_v[g] * lobe_slots(theta_i, start_v[g], slope_v[g]);
    surface[g] += front * cos_sum * F_r * half_cos_half_phi_d * g_s;
    volume[g] += front * F_t * F_t * (g_v + slot_k_d[g]);
}

#ifdef WEAVE
vec4 sums;  // surface and volume terms, of yarn 0 and of yarn 1

void sum_group(int g, vec2 side) {
    vec4 seen = rel[g] + of_yarn(g, side) * turn[g];
    vec4 s = surface[g] * slot_surface[g] * seen, v = volume[g] * seen;
    float of_weft = dot(s, slot_yarn[g]);
    sums += vec4(dot(s, vec4(1.0)) - of_weft, dot(v, slot_volume_0[g]), of_weft, dot(v, slot_volume_1[g]));
}

// The sums over the tangents of what `light_group` added, in light that leans on warp and weft; the yarns' colours are still
// to come.
vec4 sum_tangents(vec2 side) {
    sums = vec4(0.0);
#define SUM_GROUP(g) sum_group(g, side)
    EACH_GROUP(SUM_GROUP)
    return sums;
}
#else
vec3 sums;  // surface terms, volume terms of yarn 0 and of yarn 1

void sum_group(int g) {
    sums += vec3(dot(surface[g], slot_surface[g]), dot(volume[g], slot_volume_0[g]), dot(volume[g], slot_volume_1[g]));
}

// The sum over the tangents of what `light_group` added.
vec3 sum_tangents(vec2 side) {
    sums = vec3(0.0);
    EACH_GROUP(sum_group)
    return sums.x + yarn_A[0] * sums.y + yarn_A[1] * sums.z;
}
#endif

// Begins with one omega_o.
void set_omega_o(vec3 omega_o) {
    vec2 inv = inversesqrt(omega_o.xy * omega_o.xy + omega_o.z * omega_o.z);
    sin_psi_o = omega_o.xy * inv;
    cos_psi_o = omega_o.z * inv;
#define SET_OMEGA_O(g) set_omega_o_group(g, omega_o)
    EACH_GROUP(SET_OMEGA_O)
}
