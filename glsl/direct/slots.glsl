// The terms of the microcylinder model for four tangents at once, without angles.   [Miz 4-6]
// A vec4 holds one value for each of four tangents. Twin: glcloth/reference/slots.py
#include "core/math.glsl"

// [own]  The square of an angle by x = 1 - cos(angle), 0 <= x <= 2: acos(1 - x)^2 = 2 x + x^2 / 3 + 4 x^3 / 45 + ...,
// the rest of the series fitted by one term. In g(angle; 0, sigma) that is an error of 1e-5 for sigma = 20 degrees,
// 0.003 for 60, and 0.018 for 90, there near 180 degrees, where M and P vanish.
vec4 square_angle(vec4 x) {
    return x * (2.0 + x * (1.0 / 3.0 + x * (4.0 / 45.0 + 0.067381 * x * x)));
}

// [Miz, below 6]  g(angle; 0, sigma) by the angle's cosine
vec4 g_of_cos(vec4 cos_angle, float inv_sigma2) {
    return exp(-inv_sigma2 * square_angle(clamp(1.0 - cos_angle, 0.0, 2.0)));
}

// [Miz, below 6]  D(x, y, z) = (1 - x) y z + x min(y, z)
vec4 D_masks(vec4 x, vec4 y, vec4 z) {
    return mix(y * z, min(y, z), x);
}

// [Miz 12]  F_r = F_0 + (1 - F_0) (1 - cos(theta_d) cos(phi_d / 2))^5, by 4 cos^2(theta_d) and 2 cos^2(phi_d / 2)
vec4 F_slots(vec4 F_0, vec4 cos2_theta_d_4, vec4 cos2_half_phi_d_2) {
    vec4 q = max(1.0 - sqrt(0.125 * cos2_theta_d_4 * cos2_half_phi_d_2), 0.0);
    vec4 q2 = q * q;
    return F_0 + (1.0 - F_0) * (q2 * q2 * q);
}
