// Scattering by one thread: surface and volume terms.   [Miz 5]
// Directions are given in the tangent's frame, (omega . t, omega . b, omega . n), and point away from the surface.
// Angles in radians. Twin: glcloth/twins/scatter.py
#include "core/math.glsl"
#include "core/fresnel.glsl"

// [Miz 4]  g_u(x; 0, gamma) = exp(-x^2 / gamma^2) / (sqrt(pi) gamma); its integral over the real line is 1.
float g_u(float x, float gamma) {
    float q = x / gamma;
    return exp(-q * q) / (sqrt(PI) * gamma);
}

// [Miz 5, erratum E8]  The two terms of f_s, (f_rs, f_rv / A), both already divided by cos^2(theta_d):
//   f_rs = F_r(eta, theta_d, phi_d) cos(phi_d / 2) g_u(theta_h; 0, gamma_s)
//   f_rv = A F ((1 - k_d) g_u(theta_h; 0, gamma_v) + k_d) / (cos theta_i + cos theta_o),  F = (1 - F_r)^2
// Without angles: sin theta = omega . t, and sums of angles by their sines and cosines, because asin loses digits near
// the thread's poles. At a pole (omega along t) phi is undefined and the surface term takes cos(phi_d / 2) = 1.
vec2 f_s(vec3 omega_i, vec3 omega_o, float eta, float k_d, float gamma_s, float gamma_v) {
    float cos_theta_i = length(omega_i.yz);
    float cos_theta_o = length(omega_o.yz);
    float cos_theta_io = cos_theta_i * cos_theta_o;
    float sin_theta_io = omega_i.x * omega_o.x;
    float theta_h = 0.5 * atan(omega_i.x * cos_theta_o + omega_o.x * cos_theta_i, cos_theta_io - sin_theta_io);
    // cos^2 of half an angle is |u_i + u_o|^2 / 4 of the unit vectors; 1 + cos(angle) would cancel near 180 degrees.
    vec2 twice_mean = vec2(cos_theta_i + cos_theta_o, omega_i.x + omega_o.x);
    float cos2_theta_d = clamp(0.25 * dot(twice_mean, twice_mean), 1e-12, 1.0);
    vec2 azimuths = omega_i.yz / max(cos_theta_i, 1e-9) + omega_o.yz / max(cos_theta_o, 1e-9);
    float cos_half_phi_d = cos_theta_io > 1e-12 ? min(0.5 * length(azimuths), 1.0) : 1.0;
    float F_r = F_schlick(F_0(eta), sqrt(cos2_theta_d) * cos_half_phi_d);
    float F_t = (1.0 - F_r) * (1.0 - F_r);
    float surface = F_r * cos_half_phi_d * g_u(theta_h, gamma_s);
    float volume = F_t * ((1.0 - k_d) * g_u(theta_h, gamma_v) + k_d) / max(cos_theta_i + cos_theta_o, 1e-6);
    return vec2(surface, volume) / cos2_theta_d;
}
