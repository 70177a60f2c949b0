// Method `paper`: paper A literally. Per tangent and Gaussian, T from SVD-compressed tables times the integral of G f_s
// by a table over phi and piecewise linear theta segments.   [Miz 8-16]
// glcloth/methods/paper/method.py fills the textures. Every parameter but the weave is read from the fabric buffer as it is.
#include "inputs/methods/suns.glsl"
#include "sg/segments.glsl"
#include "sg/tangent_integral.glsl"
#include "sg/azimuth.glsl"
#include "sg/coordinates.glsl"

uniform sampler3D azimuth_table;  // T_l / azimuth_mass: phi_o, phi_k, kappa_prime in AZIMUTH_GROUPS
uniform sampler3D weight_xi;      // left factors of T, 4 ranks a texel: phi_k, theta_k, slices
uniform sampler3D weight_o;      // right factors: phi_o, theta_o, the same slices
uniform samplerBuffer weight_index;  // per tangent (shape, signs of theta and phi, end of theta), then first slices
uniform float grid;        // nodes of each of the tables' angles
uniform float inner;       // share of the phi_k axis below 90 degrees
uniform ivec2 tiling;      // slices per column of the 3D textures, and columns
uniform int segments;      // over theta in [-pi/2, pi/2]
uniform ivec2 lobe_range;  // first Gaussian of this pass, and the one after the last

struct Angles {
    float theta;
    float phi;
    float cos_theta;
};

Angles angles(vec3 omega) {
    float cos_theta = length(omega.yz);
    return Angles(atan(omega.x, cos_theta), atan(omega.y, omega.z), cos_theta);
}

// T of one tangent between the two sharpness levels around `level`.   [Miz 9]
// The slices of neighbouring levels follow each other, so that one loop reads both.
float fetch_T_W(int shape, vec2 at_xi, vec2 at_o, float level) {
    int low = min(int(level), LEVELS - 2);
    float above = level - float(low);
    int entry = MAX_TANGENTS + shape * (LEVELS + 1) + low;
    int s = int(texelFetch(weight_index, entry).x);
    int middle = int(texelFetch(weight_index, entry + 1).x);
    int end = int(texelFetch(weight_index, entry + 2).x);
    float T = 0.0;
    do {
        vec2 column = vec2(float(s / tiling.x), float(tiling.y));
        float z = (float(s % tiling.x) + 0.5) / float(tiling.x);
        vec4 U = textureLod(weight_xi, vec3(at_xi.x, (at_xi.y + column.x) / column.y, z), 0.0);
        vec4 V = textureLod(weight_o, vec3(at_o.x, (at_o.y + column.x) / column.y, z), 0.0);
        T += (s < middle ? 1.0 - above : above) * dot(U, V);
        ++s;
    } while (s < end);
    return T;
}

// A Gaussian that ends at `end`, integrated twice at u; `seen` is where it is last seen, and `gaussian` its value there.
// Without UPRIGHT no tangent's domain ends before its hemisphere.
vec3 integrated(vec3 u, vec3 end, vec3 slope, out vec3 seen, out vec3 gaussian) {
#ifdef UPRIGHT
    seen = min(u, end);
    gaussian = exp(-seen * seen);
    return cut_integrated(seen, gaussian, max(u - end, 0.0), slope);
#else
    seen = u;
    gaussian = exp(-u * u);
    return twice_integrated(u, gaussian);
#endif
}

#ifdef UPRIGHT
#define HAT(before, here, after, u, gaussian, left) cut_hat_integral(before, here, after, u, gaussian, step, left)
#else
#define HAT(before, here, after, u, gaussian, left) hat_integral(before, here, after, u, gaussian, step)
#endif

// (I_s, I_v / A) of one tangent and one Gaussian: integrals of G f_s cos(theta_i) over the tangent's hemisphere up to
// theta_i = theta_end >= 0.   [Miz 11-16]
// At the ends of the hemisphere cos^2(theta_i) = 0, so only inner nodes count. Nodes at theta and -theta have the same
// kappa_prime and share T_l.
vec2 I_terms(Angles k, float sharpness, Angles o, Yarn yarn, float theta_end) {
    mat3 gaussians = theta_gaussians(k.theta, sharpness, o.theta, yarn.k_d, yarn.gamma_s, yarn.gamma_v);
    vec3 mu = gaussians[0], sigma = gaussians[1], scale = gaussians[2];
    float width = PI / float(segments);
    vec3 step = width / sigma;
    float F = F_0(yarn.eta);
    float cos_half_o = cos(0.5 * o.theta);
    float sin_half_o = sin(0.5 * o.theta);
    float at_o = node_coordinate(unit_from_half_circle(k.phi < 0.0 ? -o.phi : o.phi), float(AZIMUTH_PHI_O));
    float at_k = node_coordinate(unit_from_circle(k.phi, AZIMUTH_INNER), float(AZIMUTH_PHI_K));
    const float kappa_nodes = float(AZIMUTH_KAPPA);
    const float groups = float(AZIMUTH_GROUPS);

    vec3 end = (theta_end - mu) / sigma;
    vec3 slope = 0.5 * sqrt(PI) * vec3(erf(end.x), erf(end.y), erf(end.z));
    vec3 u = (0.5 * PI - mu) / sigma;
    vec3 w = (-0.5 * PI - mu) / sigma;
    vec3 seen_u, seen_w, g_u, g_w;
    vec3 before_u = integrated(u, end, slope, seen_u, g_u);
    vec3 before_w = integrated(w, end, slope, seen_w, g_w);
    u -= step;
    w += step;
    vec3 here_u = integrated(u, end, slope, seen_u, g_u);
    vec3 here_w = integrated(w, end, slope, seen_w, g_w);
    vec2 I = vec2(0.0);
    float theta = 0.5 * PI - width;
    int node = 1;
    do {
        vec3 next_u = u - step;
        vec3 next_w = w + step;
        vec3 next_seen_u, next_seen_w, next_g_u, next_g_w;
        vec3 after_u = integrated(next_u, end, slope, next_seen_u, next_g_u);
        vec3 after_w = integrated(next_w, end, slope, next_seen_w, next_g_w);
        vec2 left = (theta_end - vec2(theta, -theta)) / width;
        vec3 weight_u = scale * HAT(before_u, here_u, after_u, seen_u, g_u, left.x);
        vec3 weight_w = scale * HAT(before_w, here_w, after_w, seen_w, g_w, left.y);
        float cos_half = cos(0.5 * theta);
        float sin_half = sin(0.5 * theta);
        float cos_theta = 2.0 * cos_half * cos_half - 1.0;
        float kappa_prime = sharpness * cos_theta * k.cos_theta;
        float z = node_coordinate(unit_from_kappa(kappa_prime, KAPPA_LAST), kappa_nodes) / groups;
        float mass = azimuth_mass(k.phi, kappa_prime);
        vec4 T_1 = mass * textureLod(azimuth_table, vec3(at_o, at_k, z), 0.0);
        vec4 T_5 = mass * textureLod(azimuth_table, vec3(at_o, at_k, z + 1.0 / groups), 0.0);
        vec4 T_9 = mass * textureLod(azimuth_table, vec3(at_o, at_k, z + 2.0 / groups), 0.0);
        // The middle node of an even number of segments is its own mirror image.
        float count = 2 * node == segments ? 0.5 : 1.0;
        vec2 cos_theta_d = vec2(cos_half * cos_half_o + sin_half * sin_half_o, cos_half * cos_half_o - sin_half * sin_half_o);
        float slope = 1.0 / (cos_theta + o.cos_theta);
        I += count * node_terms(weight_u, cos_theta, cos_theta_d.x, slope, F, T_1, T_5, T_9);
        I += count * node_terms(weight_w, cos_theta, cos_theta_d.y, slope, F, T_1, T_5, T_9);
        before_u = here_u;
        before_w = here_w;
        here_u = after_u;
        here_w = after_w;
        u = next_u;
        w = next_w;
        seen_u = next_seen_u;
        seen_w = next_seen_w;
        g_u = next_g_u;
        g_w = next_g_w;
        theta -= width;
        ++node;
    } while (2 * node <= segments);
    return I;
}

// The factors of T and I for one tangent under all Gaussians of this pass, summed.   [Miz 8]
// do-while: Mesa's software rasteriser runs the body of a for loop once more than it counts.
vec3 L_tangent(int t, int j, Yarn yarn, vec3 omega_o, mat3 surface_from_world) {
    Tangent tangent = fetch_tangent(t);
    vec3 local_o = tangent_from_surface(omega_o, j, tangent.cos_tilt, tangent.sin_tilt);
    if (local_o.z <= 0.0 || tangent.weight == 0.0) return vec3(0.0);
    Angles o = angles(local_o);
    vec4 placement = texelFetch(weight_index, t);
    // The domain of an upright tangent ends where theta is positive: one that leans the other way is seen in a mirror.
    float mirror = placement.w < 0.5 * PI && tangent.sin_tilt < 0.0 ? -1.0 : 1.0;
    Angles in_o = Angles(mirror * o.theta, o.phi, o.cos_theta);
    vec2 at_o = vec2(node_coordinate(unit_from_half_circle(placement.z * o.phi), grid),
        node_coordinate(unit_from_half_circle(placement.y * o.theta), grid));
    vec3 sum = vec3(0.0);
#ifdef WEAVE
    vec2 seen = rel_and_turn(t);
#endif
    int n = lobe_range.x;
    do {
        Gaussian light = fetch_gaussian(n);
        vec3 xi = surface_from_world * light.xi;
        vec3 local_k = tangent_from_surface(xi, j, tangent.cos_tilt, tangent.sin_tilt);
        Angles k = angles(local_k);
        float phi_k = placement.z * k.phi;
        float circle = unit_from_circle(phi_k, inner);
        vec2 at_xi = vec2(node_coordinate(0.5 + 0.5 * (phi_k < 0.0 ? -circle : circle), grid),
            node_coordinate(unit_from_half_circle(placement.y * k.theta), grid));
        float level = level_from_sharpness(light.sharpness, SHARPNESS_FIRST, SHARPNESS_LAST, float(LEVELS));
        // Truncated factors may dip below zero where T is zero.
        float T = max(fetch_T_W(int(placement.x), at_xi, at_o, level), 0.0);
        vec2 I = I_terms(Angles(mirror * k.theta, k.phi, k.cos_theta), light.sharpness, in_o, yarn, placement.w);
#ifdef WEAVE
        // The side of a yarn turns to the axis of a Gaussian as to a sun.
        I *= seen_of(seen, j, xi);
        vec3 f = COLORED(j == 0 ? vec4(I, 0.0, 0.0) : vec4(0.0, 0.0, I));
#else
        vec3 f = I.x + yarn.A * I.y;
#endif
        sum += V_gaussian(n) * T * f * light.L;
        ++n;
    } while (n < lobe_range.y);
    return tangent.weight * sum;
}

vec3 L_o(vec3 omega_o, mat3 surface_from_world) {
    vec3 sum = L_suns(omega_o, surface_from_world);
    if (lobe_range.x >= lobe_range.y) return sum;
    int t = 0;
    int last = 0;
    for (int j = 0; j < 2; ++j) {
        Yarn yarn = fetch_yarn(j);
        last += tangent_count[j];
        do {
            sum += L_tangent(t, j, yarn, omega_o, surface_from_world);
            ++t;
        } while (t < last);
    }
    return sum;
}
