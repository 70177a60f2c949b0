// Method `direct`: quadrature at nodes that are shared by all tangents and all lobes; no tables of the fabric.   [own]
//   L_o = sum_k L_k sum_n w_n sum_t R_t(omega_n) cos(theta_i) (f_rs + A_j f_rv),   R_t = w_t M_t P_t / Q
// Defines: GROUPS, vec4s that hold the tangents; EACH_GROUP(F), that is F(0); F(1); ... F(GROUPS - 1); LANES, 1 for each
// component of those vec4s that is in use; POOLED(L), L or nothing. See docs/direct.md.
#include "core/math.glsl"
#include "direct/node.glsl"
#include "direct/pool.glsl"
#include "direct/slots.glsl"
#include "trace/octahedron.glsl"
#include "seen.glsl"

const int NODE_COLUMNS = 64;   // glcloth/cloth/gaussian_nodes.py says the same
const int LOBE_COLUMNS = 64;   // glcloth/cloth/lobe_nodes.py says the same
const int ENTRY_TEXELS = 5;    // glcloth/cloth/direct.py says the same
const float MAP_SIZE = 160.0;   // glcloth/cloth/direct.py says the same
const int MAX_PHI_PAIRS = 8;    // glcloth/cloth/direct.py says the same

layout(binding = 8) uniform samplerBuffer node_data;   // rows of NODE_COLUMNS: (a, b, c, share); after each rule its mean
layout(binding = 9) uniform samplerBuffer entry_data;  // ENTRY_TEXELS for each Gaussian and rule, or sun
layout(binding = 10) uniform samplerBuffer lobe_data;  // per pooled tangent: two texels, then rows of LOBE_COLUMNS
layout(binding = 11) uniform sampler2D pooled_light;   // radiance of the pooled Gaussians, world, octahedral
layout(binding = 12) uniform sampler2D sky_light;      // radiance of the broadest Gaussians, likewise
uniform int entry_count;                // at least 1
uniform ivec2 sky_nodes;                // first texel of the sky's nodes in node_data, and the one behind the last
uniform vec4 sky_kept, sky_sharp, sky_height;  // as entry_kept, ...
uniform ivec3 pool_counts;              // pooled tangents, their nodes in theta, their pairs in phi; at least 1 each
uniform vec2 phi_rule[MAX_PHI_PAIRS];   // nodes > 0 and weights of a Gauss-Legendre rule on -1..1
uniform vec4 mask_series;               // of g_of_cos, for sigma of shadowing and masking
uniform float gap;                      // 1 - a_1 - a_2 in W's normaliser
uniform vec3 yarn_A[2];
uniform vec2 yarn_F_0;
// Four tangents each; unused ones weigh nothing. A LANES of 0 is a constant that lets the compiler drop a component.
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

void see_group(int g, vec3 omega_o) {
    vec4 along = of_yarn(g, omega_o.xy), across = of_yarn(g, vec2(omega_o.y, -omega_o.x));
    vec4 t = along * slot_cos_tilt[g] - omega_o.z * slot_sin_tilt[g];
    vec4 n = along * slot_sin_tilt[g] + omega_o.z * slot_cos_tilt[g];
    vec4 c2 = max(1.0 - t * t, 1e-7);
    vec4 inv = inversesqrt(c2);
    sin_theta_o[g] = t;
    cos_theta_o[g] = c2 * inv;
    theta_o[g] = twice_atan(t / (1.0 + cos_theta_o[g]));
    cos_phi_o[g] = n * inv;
    sin_phi_o[g] = across * inv;
    cos_psi_t[g] = max(of_yarn(g, cos_psi_o) * slot_cos_tilt[g] + of_yarn(g, sin_psi_o) * slot_sin_tilt[g], 0.0);
}

// What depends on one direction omega_i and the yarn only.
vec2 sin_psi_i, cos_psi_i, g_psi;

void look_along(vec3 omega_i) {
    vec2 inv = inversesqrt(omega_i.xy * omega_i.xy + omega_i.z * omega_i.z + 1e-20);
    sin_psi_i = omega_i.xy * inv;
    cos_psi_i = omega_i.z * inv;
    g_psi = g_of_cos(vec4(cos_psi_i * cos_psi_o + sin_psi_i * sin_psi_o, 0.0, 0.0), mask_series).xy;
}

float Q;

void add_P(int g) {
    vec4 c = max(of_yarn(g, cos_psi_i) * slot_cos_tilt[g] + of_yarn(g, sin_psi_i) * slot_sin_tilt[g], 0.0);
    shared_P[g] = slot_share[g] * LANES * D_masks(of_yarn(g, g_psi), c, cos_psi_t[g]);
    Q += dot(shared_P[g], vec4(1.0));
}

// -- Gaussians at their own nodes ---------------------------------------------------------------------------------------

// Of one entry; components (surface of yarn 0, surface of yarn 1, volume of yarn 0, volume of yarn 1): how much of its
// distance from the mean a node keeps; the widened lobe is exp2(height - (sharp (theta_i + theta_o))^2).
vec4 entry_kept, entry_sharp, entry_height;
// The exponents as polynomials of the node's theta_i: c_0 + theta_i (c_1 + theta_i c_2).
vec4 s_0[GROUPS], s_1[GROUPS], s_2[GROUPS], v_0[GROUPS], v_1[GROUPS], v_2[GROUPS];

void aim_group(int g, vec3 mean) {
    vec4 t = of_yarn(g, mean.xy) * slot_cos_tilt[g] - mean.z * slot_sin_tilt[g];
    vec4 theta_mean = twice_atan(t / (1.0 + sqrt(max(1.0 - t * t, 0.0))));
    vec4 kept_s = of_yarn(g, entry_kept.xy), kept_v = of_yarn(g, entry_kept.zw);
    vec4 sharp_s = of_yarn(g, entry_sharp.xy), sharp_v = of_yarn(g, entry_sharp.zw);
    vec4 start_s = sharp_s * (theta_o[g] + (1.0 - kept_s) * theta_mean), slope_s = sharp_s * kept_s;
    vec4 start_v = sharp_v * (theta_o[g] + (1.0 - kept_v) * theta_mean), slope_v = sharp_v * kept_v;
    s_0[g] = of_yarn(g, entry_height.xy) - start_s * start_s;
    s_1[g] = -2.0 * start_s * slope_s;
    s_2[g] = -slope_s * slope_s;
    v_0[g] = of_yarn(g, entry_height.zw) - start_v * start_v;
    v_1[g] = -2.0 * start_v * slope_v;
    v_2[g] = -slope_v * slope_v;
    surface[g] = volume[g] = vec4(0.0);
}

// Adds the terms at one node, but for a factor 8 of the surface term and 4 of the volume term, which `sum_group` knows. No term needs a clamp at its tangent's horizon,
// where P vanishes.
void light_group(int g, vec3 omega_i, float weight) {
    vec4 along = of_yarn(g, omega_i.xy), across = of_yarn(g, vec2(omega_i.y, -omega_i.x));
    vec4 t = along * slot_cos_tilt[g] - omega_i.z * slot_sin_tilt[g];
    vec4 n = along * slot_sin_tilt[g] + omega_i.z * slot_cos_tilt[g];
    vec4 c2 = max(1.0 - t * t, 1e-7);
    vec4 inv = inversesqrt(c2);
    vec4 cos_theta_i = c2 * inv, cos_phi_i = n * inv;
    vec4 cos_phi_d = (n * cos_phi_o[g] + across * sin_phi_o[g]) * inv;
    vec4 M = D_masks(g_of_cos(cos_phi_d, mask_series), cos_phi_i, cos_phi_o[g]);
    vec4 half_cos_half_phi_d = sqrt(max(0.125 + 0.125 * cos_phi_d, 0.0));
    vec4 cos_sum = cos_theta_i + cos_theta_o[g], sin_sum = t + sin_theta_o[g];
    vec4 cos2_theta_d_4 = cos_sum * cos_sum + sin_sum * sin_sum;
    vec4 F_r = F_slots(slot_F_0[g], sqrt(cos2_theta_d_4), half_cos_half_phi_d), F_t = 1.0 - F_r;
    // 1 / (cos^2(theta_d) (cos theta_i + cos theta_o)); the surface term takes the sum out again.
    vec4 front = weight * shared_P[g] * M * cos_theta_i / (cos2_theta_d_4 * cos_sum);
    vec4 theta_i = twice_atan(t / (1.0 + cos_theta_i));
    vec4 g_s = exp2(s_0[g] + theta_i * (s_1[g] + theta_i * s_2[g]));
    vec4 g_v = exp2(v_0[g] + theta_i * (v_1[g] + theta_i * v_2[g]));
    surface[g] += front * cos_sum * F_r * half_cos_half_phi_d * g_s;
    volume[g] += front * F_t * F_t * (g_v + slot_k_d[g]);
}

vec3 sums;  // surface terms, volume terms of yarn 0 and of yarn 1

void sum_group(int g) {
    sums += vec3(dot(surface[g], slot_surface[g]), dot(volume[g], slot_volume_0[g]), dot(volume[g], slot_volume_1[g]));
}

// The sum over the tangents of what `light_group` added.
vec3 sum_tangents() {
    sums = vec3(0.0);
    EACH_GROUP(sum_group)
    return sums.x + yarn_A[0] * sums.y + yarn_A[1] * sums.z;
}

vec4 fetch_node(int row, int column, float between) {
    int at = row * NODE_COLUMNS + column;
    vec4 a = texelFetch(node_data, at), b = texelFetch(node_data, at + 1);
    return a + between * (b - a);
}

vec3 L_shared(float cos_o, mat3 surface_from_world) {
    vec3 L = vec3(0.0);
    int k = 0;
    // A do loop: llvmpipe runs the body of a while loop once more than it is wanted.
    do {
        int at = k * ENTRY_TEXELS;
        vec4 head = texelFetch(entry_data, at);       // xi in world space; number of its V, first row of its rule, rows
        vec4 light = texelFetch(entry_data, at + 1);  // radiance of the axis; width of its columns
        vec4 extra = texelFetch(entry_data, at + 2);
        entry_kept = extra;
        entry_sharp = texelFetch(entry_data, at + 3);
        entry_height = texelFetch(entry_data, at + 4);
        int rows = floatBitsToInt(head.w);
        int node = rows >> 8 & 0xffff, last = node + (rows & 255);
        vec3 xi = surface_from_world * head.xyz;
        vec2 e = azimuth(xi);
        float place = column_of(atan(length(xi.xy), xi.z), light.w) * float(NODE_COLUMNS - 1);
        int column = min(int(place), NODE_COLUMNS - 2);
        float between = place - float(column);
        vec4 mean = fetch_node(last, column, between);
        vec3 omega_mean = direction_from_node(mean.xyz, xi, e);
#define AIM(g) aim_group(g, omega_mean)
        EACH_GROUP(AIM)
        do {
            vec4 rule = fetch_node(node, column, between);
            vec3 omega_i = direction_from_node(rule.xyz, xi, e);
            omega_i.z = max(omega_i.z, 0.0);
            look_along(omega_i);
            Q = gap * cos_o + 1e-20;
            EACH_GROUP(add_P)
            float weight = rule.w / Q;
#define LIGHT(g) light_group(g, omega_i, weight)
            EACH_GROUP(LIGHT)
        } while (++node < last);
        L += light.rgb * (exp(mean.w) * V_number(rows >> 24)) * sum_tangents();
    } while (++k < entry_count);
    return L;
}

// -- the broadest Gaussians together, at fixed nodes --------------------------------------------------------------------

// The radiance of a map in a direction of world space.
vec3 map_radiance(sampler2D map, vec3 omega) {
    // Texel centres on the rim of the square: there it is folded, and both sides hold the same value.
    return textureLod(map, 0.5 + (0.5 - 0.5 / MAP_SIZE) * octahedral(omega), 0.0).rgb;
}

vec3 L_sky(float cos_o, mat3 surface_from_world) {
    vec3 L = vec3(0.0);
    entry_kept = sky_kept;
    entry_sharp = sky_sharp;
    entry_height = sky_height;
    vec3 up = vec3(0.0, 0.0, 1.0);
#define AIM_UP(g) aim_group(g, up)
#define CLEAR(g) surface[g] = volume[g] = vec4(0.0)
    EACH_GROUP(AIM_UP)
    int node = sky_nodes.x;
    do {
        vec4 rule = texelFetch(node_data, node);
        look_along(rule.xyz);
        Q = gap * cos_o + 1e-20;
        EACH_GROUP(add_P)
        float weight = rule.w / Q;
#define LIGHT_SKY(g) light_group(g, rule.xyz, weight)
        EACH_GROUP(CLEAR)
        EACH_GROUP(LIGHT_SKY)
        vec3 omega = rule.xyz * surface_from_world;
        L += map_radiance(sky_light, omega) * V_broad(rule.xyz) * sum_tangents();
    } while (++node < sky_nodes.y);
    return L;
}

// -- broad Gaussians together, at the nodes of narrow lobes -------------------------------------------------------------

vec3 L_pooled(vec3 omega_o, mat3 surface_from_world) {
    vec3 L = vec3(0.0);
    int stride = 2 + pool_counts.y * LOBE_COLUMNS;
    int p = 0;
    do {
        vec4 head = texelFetch(lobe_data, p * stride);      // cos and sin of the tilt, weight, yarn
        vec4 domain = texelFetch(lobe_data, p * stride + 1);  // low, high, width
        bool first_yarn = head.w == 0.0;
        float ca = head.x, sa = head.y;
        vec2 o = first_yarn ? omega_o.xy : vec2(omega_o.y, -omega_o.x);  // along, across
        float t_o = o.x * ca - omega_o.z * sa, n_o = o.x * sa + omega_o.z * ca;
        float c2_o = max(1.0 - t_o * t_o, 1e-7), inv_o = inversesqrt(c2_o), c_o = c2_o * inv_o;
        vec2 phi_o = vec2(n_o, o.y) * inv_o;  // cos, sin
        float psi_o = max(n_o * inversesqrt(o.x * o.x + omega_o.z * omega_o.z + 1e-20), 0.0);
        // Cosine and sine of psi_o of its own yarn and of the other, as its frame sees them.
        vec2 psi_own = first_yarn ? vec2(cos_psi_o.x, sin_psi_o.x) : vec2(cos_psi_o.y, sin_psi_o.y);
        vec2 psi_other = first_yarn ? vec2(cos_psi_o.y, sin_psi_o.y) : vec2(cos_psi_o.x, -sin_psi_o.x);
        float F_0 = first_yarn ? yarn_F_0.x : yarn_F_0.y;
        float mu = -twice_atan(vec4(t_o / (1.0 + c_o))).x;
        float place = column_of_lobe(mu, domain.x, domain.y, domain.z) * float(LOBE_COLUMNS - 1);
        int column = min(int(place), LOBE_COLUMNS - 2);
        float between = place - float(column);
        vec3 sum_s = vec3(0.0), sum_v = vec3(0.0);
        int row = 0;
        do {
            int at = p * stride + 2 + row * LOBE_COLUMNS + column;
            vec4 lobe = mix(texelFetch(lobe_data, at), texelFetch(lobe_data, at + 1), between);
            float theta = mu + lobe.x;
            float t = sin(theta), c = max(cos(theta), 3e-4);
            float limit = sin_limit(t, c, ca, sa);
            float cos_sum = c + c_o, sin_sum = t + t_o;
            float cos_theta_d = 0.5 * sqrt(max(cos_sum * cos_sum + sin_sum * sin_sum, 4e-7));
            // cos(theta_i) of the integrand and of the solid angle, 1 / cos^2(theta_d)
            float front = head.z * c * c / (cos_theta_d * cos_theta_d);
            float front_v = front / cos_sum;
            int pair = 0;
            do {
                vec2 rule = phi_rule[pair];
                float s = limit * rule.x, cp = sqrt(max(1.0 - s * s, 1e-12));
                // along, across, z of the two directions at phi and -phi
                float along = t * ca + c * cp * sa, z = max(c * cp * ca - t * sa, 0.0), side = c * s;
                vec3 omega_1 = first_yarn ? vec3(along, side, z) : vec3(-side, along, z);
                vec3 omega_2 = first_yarn ? vec3(along, -side, z) : vec3(side, along, z);
                // They differ in the sine of the other yarn's psi only.
                vec2 inv = inversesqrt(vec2(along, side) * vec2(along, side) + z * z + 1e-20);  // own yarn, other yarn
                vec2 sines = vec2(along, side) * inv, cosines = z * inv;
                vec4 g = g_of_cos(
                    vec4(cosines.x * psi_own.x + sines.x * psi_own.y,
                         cosines.y * psi_other.x + vec2(sines.y, -sines.y) * psi_other.y, 0.0),
                    mask_series);
                cos_psi_i = first_yarn ? cosines : cosines.yx;
                sin_psi_i = first_yarn ? sines : vec2(-sines.y, sines.x);
                g_psi = first_yarn ? g.xy : g.yx;
                Q = gap * omega_o.z + 1e-20;
                EACH_GROUP(add_P)
                float Q_1 = Q;
                sin_psi_i = first_yarn ? vec2(sines.x, -sines.y) : vec2(sines.y, sines.x);
                g_psi = first_yarn ? g.xz : g.zx;
                Q = gap * omega_o.z + 1e-20;
                EACH_GROUP(add_P)
                float psi = max(cosines.x * ca + sines.x * sa, 0.0), g_own = g.x;
                vec4 cos_phi_d = vec4(cp * phi_o.x + s * phi_o.y, cp * phi_o.x - s * phi_o.y, 0.0, 0.0);
                vec4 M = D_masks(g_of_cos(cos_phi_d, mask_series), vec4(cp), vec4(max(phi_o.x, 0.0)));
                vec4 cos_half_phi_d = sqrt(max(0.5 + 0.5 * cos_phi_d, 0.0));
                vec4 F_r = F_slots(vec4(F_0), vec4(cos_theta_d), cos_half_phi_d);
                float P_t = mix(psi * psi_o, min(psi, psi_o), g_own);
                vec2 R = rule.y / cp * P_t * M.xy / vec2(Q_1, Q);
                vec2 r_s = front * lobe.y * R * F_r.xy * cos_half_phi_d.xy;
                vec2 r_v = front_v * lobe.z * R * (1.0 - F_r.xy) * (1.0 - F_r.xy);
                vec3 E_1 = map_radiance(pooled_light, omega_1 * surface_from_world) * V_broad(omega_1);
                vec3 E_2 = map_radiance(pooled_light, omega_2 * surface_from_world) * V_broad(omega_2);
                sum_s += E_1 * r_s.x + E_2 * r_s.y;
                sum_v += E_1 * r_v.x + E_2 * r_v.y;
            } while (++pair < pool_counts.z);
        } while (++row < pool_counts.y);
        L += sum_s + (first_yarn ? yarn_A[0] : yarn_A[1]) * sum_v;
    } while (++p < pool_counts.x);
    return L;
}

vec3 L_o(vec3 omega_o, mat3 surface_from_world) {
    vec2 inv = inversesqrt(omega_o.xy * omega_o.xy + omega_o.z * omega_o.z);
    sin_psi_o = omega_o.xy * inv;
    cos_psi_o = omega_o.z * inv;
#define SEE(g) see_group(g, omega_o)
    EACH_GROUP(SEE)
    return L_shared(omega_o.z, surface_from_world) + L_sky(omega_o.z, surface_from_world) POOLED(+ L_pooled(omega_o, surface_from_world));
}
