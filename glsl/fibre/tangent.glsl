// The terms of one tangent in the sum over a fabric's tangents, before W's normaliser Q is known.   [Miz 5-6]
// Directions are given in the tangent's frame, (omega . t, omega . b, omega . n). Twin: glcloth/twins/tangent.py
#include "fibre/scatter.glsl"
#include "fibre/weight.glsl"

// [Miz 5-6, erratum E8]  (P, R f_rs cos(theta_i), R f_rv cos(theta_i) / A) with R = weight M P. The cloth is
// sum_t (R f_rs + A R f_rv) cos(theta_i) / Q, Q = sum_t share P + gap cos(theta_o).
vec3 tangent_terms(vec3 omega_i, vec3 omega_o, float weight, float eta, float k_d, float gamma_s, float gamma_v, float sigma) {
    float P_t = P(omega_i, omega_o, sigma);
    float R = weight * M(omega_i, omega_o, sigma) * P_t;
    return vec3(P_t, R > 0.0 ? R * length(omega_i.yz) * f_s(omega_i, omega_o, eta, k_d, gamma_s, gamma_v) : vec2(0.0));
}
