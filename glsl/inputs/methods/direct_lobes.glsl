// Nodes on the narrow lobes of the tangents, for light that is broad: calls add_node(omega_i, weight) at each.   [own]
// The pass that includes this defines `add_node` before.
#include "direct/pool.glsl"
#include "inputs/methods/direct_tangents.glsl"

// glcloth/methods/direct reads these numbers here.
const int LOBE_COLUMNS = 64;
const int MAX_PHI_PAIRS = 8;

uniform samplerBuffer lobe_data;  // per pooled tangent: two texels, then rows of LOBE_COLUMNS
uniform ivec3 pool_counts;              // pooled tangents, their nodes in theta, their pairs in phi; at least 1 each
uniform vec2 phi_rule[MAX_PHI_PAIRS];   // nodes > 0 and weights of a Gauss-Legendre rule on -1..1
uniform vec2 yarn_F_0;
#ifdef TERMS
#define NODE(s, v, omega) node_sums(vec2(s, v), first_yarn)
#elif defined(WEAVE)
#define NODE(s, v, omega) node_sums(vec2(s, v) * seen_of(seen, first_yarn ? 0 : 1, omega), first_yarn)
#else
#define NODE(s, v, omega) s + A * v
#endif

vec4 node_sums(vec2 terms, bool first_yarn) { return first_yarn ? vec4(terms, 0.0, 0.0) : vec4(0.0, 0.0, terms); }

void visit_lobes(vec3 omega_o) {
    int stride = 2 + pool_counts.y * LOBE_COLUMNS;
    int p = 0;
    do {
        vec4 head = texelFetch(lobe_data, p * stride);      // cos and sin of the tilt, weight, yarn
        vec4 domain = texelFetch(lobe_data, p * stride + 1);  // low, high, width, number
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
        vec3 A = first_yarn ? yarn_A[0] : yarn_A[1];
#ifdef WEAVE
        vec2 seen = rel_and_turn(int(domain.w));
#endif
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
                float P_t = mix(psi * psi_o, min(psi, psi_o), g_own);
                mat3x2 f = scatter_pair(cp, s, phi_o, cos_theta_d, F_0, mask_series);
                vec2 R = rule.y / cp * P_t * f[0] / vec2(Q_1, Q), F_r = f[1], cos_half_phi_d = f[2];
                vec2 r_s = front * lobe.y * R * F_r * cos_half_phi_d;
                vec2 r_v = front_v * lobe.z * R * (1.0 - F_r) * (1.0 - F_r);
                add_node(omega_1, NODE(r_s.x, r_v.x, omega_1));
                add_node(omega_2, NODE(r_s.y, r_v.y, omega_2));
            } while (++pair < pool_counts.z);
        } while (++row < pool_counts.y);
#ifdef TERMS
        end_lobe(int(domain.w));
#endif
    } while (++p < pool_counts.x);
}
