// Where an angle or a sharpness lies in the paper method's tables; glcloth/methods/paper/precompute.py reads the constants.
// Twin, with the inverse maps: glcloth/twins/coordinates.py
#include "core/math.glsl"

const int AZIMUTH_PHI_O = 48;          // nodes of T_l(phi_o, phi_k, kappa_prime)   [Miz 14, section 4]
const int AZIMUTH_PHI_K = 48;          // over |phi_k| in [0, pi]: (phi_o, phi_k) and (-phi_o, -phi_k) are the same
const int AZIMUTH_KAPPA = 32;
const int AZIMUTH_GROUPS = 3;          // texels of 4 powers each: 1-4, 5-8, 9-10
const float AZIMUTH_INNER = 0.65957447;  // 31/47, a node: the share of T_l's phi_k axis that lies below 90 degrees
const float KAPPA_LAST = 2000.0;       // largest kappa_prime of T_l; beyond it only its mass changes
const int LEVELS = 16;                 // sharpness levels of T_W: one at 0, then
const float SHARPNESS_FIRST = 0.5;     // from here
const float SHARPNESS_LAST = 1500.0;   // to here in equal ratios; sharper lobes use the last level

// [own]  Texture coordinate of x in [0, 1] in a table of n texels with its first node at 0 and its last at 1.
float node_coordinate(float x, float n) {
    return (0.5 + clamp(x, 0.0, 1.0) * (n - 1.0)) / n;
}

// [own]  [-pi/2, pi/2] to [0, 1]: theta of both directions, phi of omega_o.
float unit_from_half_circle(float angle) {
    return angle / PI + 0.5;
}

// [own]  |phi| in [0, pi] to [0, 1] such that the share `inner` lies below pi/2. That point must be a node: the tangent
// sees nothing beyond it, and tables have a bend there. Beyond it they are smooth and count for little.
float unit_from_circle(float phi, float inner) {
    float x = abs(phi) / (0.5 * PI);
    return x < 1.0 ? x * inner : inner + (x - 1.0) * (1.0 - inner);
}

// [own]  kappa_prime >= 0 of T_l to [0, 1] at `last`, logarithmic: halving a width counts the same at every width.
float unit_from_kappa(float kappa_prime, float last) {
    return log(1.0 + kappa_prime) / log(1.0 + last);
}

// [own]  Sharpness 2 / sigma_k^2 >= 0 to the levels of T_W: level 0 is a constant environment, level 1 is `first`, and
// the rest follow in equal ratios up to `last` at levels - 1, which sharper lobes share.
float level_from_sharpness(float sharpness, float first, float last, float levels) {
    float x = sharpness / first;
    return x < 1.0 ? x : min(1.0 + (levels - 2.0) * log(max(x, 1.0)) / log(last / first), levels - 1.0);
}
