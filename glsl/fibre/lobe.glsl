// Directions drawn from the lobes of one tangent, so that bright directions are drawn more often.   [own]
// Directions are given in the tangent's frame, (omega . t, omega . b, omega . n), with omega_o . n > 0. Of the two lobes the
// surface term is number 1, the directed part of the volume term 0. Twin: glcloth/twins/lobe.py
#include "core/erf.glsl"
#include "fibre/scatter.glsl"

const float LEAST_COS = 0.1;  // of theta_o in weights: toward the thread's ends the lobes do not grow as the model's factor does

// [own]  theta_h where theta_i is -90 and 90 degrees, as erf(theta_h / gamma): what is drawn lies between.
vec2 lobe_ends(vec3 omega_o, float gamma) {
    float half_theta_o = 0.5 * atan(omega_o.x, length(omega_o.yz));
    return vec2(erf((half_theta_o - 0.25 * PI) / gamma), erf((half_theta_o + 0.25 * PI) / gamma));
}

// [own]  About how much light each lobe sends toward omega_o, (volume, surface); `A` is the luminance of the yarn's albedo.
vec2 lobe_weights(vec3 omega_o, float weight, float A, float eta, float k_d, vec2 ends_v, vec2 ends_s) {
    float cos_theta = length(omega_o.yz);
    float cos_psi = omega_o.z / max(length(omega_o.xz), 1e-9);
    float cos_half_phi = sqrt(max(0.5 + 0.5 * omega_o.z / max(cos_theta, 1e-9), 0.0));
    float F = F_schlick(F_0(eta), cos_theta * cos_half_phi);
    float c = max(cos_theta, LEAST_COS);
    float volume = max(A, 1e-4) * (1.0 - F) * (1.0 - F) * (1.0 - k_d) * (ends_v.y - ends_v.x) / (c * c);
    float surface = 2.0 * F * (ends_s.y - ends_s.x) / c;
    return omega_o.z > 0.0 ? weight * cos_psi * vec2(volume, surface) : vec2(0.0);
}

// [own]  A direction of a lobe by two numbers from 0 to 1: theta_h as the Gaussian, and phi as cos(phi_i), or of the surface
// lobe as cos(phi_d / 2), within 90 degrees of n.
vec3 lobe_direction(vec3 omega_o, float gamma, vec2 ends, int lobe, vec2 u) {
    float cos_theta_o = length(omega_o.yz);
    float theta_h = gamma * erf_inverse(clamp(mix(ends.x, ends.y, u.x), -0.9999998, 0.9999998));
    float theta_i = clamp(2.0 * theta_h - atan(omega_o.x, cos_theta_o), -0.5 * PI, 0.5 * PI);
    float phi_o = atan(omega_o.y, omega_o.z);
    float a = sin(-0.25 * PI - 0.5 * phi_o), b = sin(0.25 * PI - 0.5 * phi_o);
    float phi_i = lobe == 1 ? phi_o + 2.0 * asin(clamp(mix(a, b, u.y), -1.0, 1.0)) : asin(clamp(2.0 * u.y - 1.0, -1.0, 1.0));
    float cos_theta_i = cos(theta_i);
    return vec3(sin(theta_i), cos_theta_i * sin(phi_i), cos_theta_i * cos(phi_i));
}

// [own]  The density of omega_i among the directions of a lobe, per solid angle.
float lobe_pdf(vec3 omega_i, vec3 omega_o, float gamma, vec2 ends, int lobe) {
    float cos_theta_i = length(omega_i.yz), cos_theta_o = length(omega_o.yz);
    float theta_h = 0.5 * (atan(omega_i.x, cos_theta_i) + atan(omega_o.x, cos_theta_o));
    float of_theta = g_u(theta_h, gamma) / max(ends.y - ends.x, 1e-6);
    vec2 azimuth_i = omega_i.yz / max(cos_theta_i, 1e-9), azimuth_o = omega_o.yz / max(cos_theta_o, 1e-9);
    float cos_half_phi_o = sqrt(max(0.5 + 0.5 * azimuth_o.y, 0.0));
    // b - a of `lobe_direction` is sqrt(2) cos(phi_o / 2).
    float of_phi = lobe == 1 ? 0.25 * length(azimuth_i + azimuth_o) / max(sqrt(2.0) * cos_half_phi_o, 1e-9) : 0.5 * azimuth_i.y;
    return omega_i.z > 0.0 ? of_theta * of_phi / max(cos_theta_i, 1e-6) : 0.0;
}
