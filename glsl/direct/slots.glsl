// The terms of the microcylinder model for four tangents at once, without angles.   [Miz 4-6]
// A vec4 holds one value for each of four tangents. Twin: glcloth/twins/slots.py
#include "core/math.glsl"

// [Miz, below 6]  g(angle; 0, sigma) = exp(-angle^2 / sigma^2) by the angle's cosine. With x = 1 - cos(angle),
// angle^2 = 2 x + x^2 / 3 + 4 x^3 / 45 + ..., the rest of the series fitted by 0.067381 x^5; series = those four
// coefficients times -1 / (sigma^2 ln 2). Off by 1e-5 for sigma = 20 degrees, 0.003 for 60, and 0.018 for 90, there near
// 180 degrees, where M and P vanish.
vec4 g_of_cos(vec4 cos_angle, vec4 series) {
    vec4 x = max(1.0 - cos_angle, 0.0);  // at a tangent's pole rounding makes any cosine
    return exp2(x * (series.x + x * (series.y + x * (series.z + series.w * x * x))));
}

// [Miz, below 6]  D(x, y, z) = (1 - x) y z + x min(y, z)
vec4 D_masks(vec4 x, vec4 y, vec4 z) {
    vec4 yz = y * z;
    return yz + x * (min(y, z) - yz);
}

// [Miz 12]  F_r = F_0 + (1 - F_0) (1 - cos(theta_d) cos(phi_d / 2))^5
vec4 F_slots(vec4 F_0, vec4 cos_theta_d, vec4 cos_half_phi_d) {
    vec4 q = 1.0 - cos_theta_d * cos_half_phi_d;
    vec4 q2 = q * q;
    return F_0 + (1.0 - F_0) * (q2 * q2 * q);
}

// [own]  2 atan(y) for y from -1 to 1, off by 4e-6 (Abramowitz & Stegun 4.4.49 is the shorter polynomial). With
// y = sin / (1 + cos) it is the angle; GLSL's asin may be off by 4e-4, too much for lobes of a degree.
vec4 twice_atan(vec4 y) {
    vec4 y2 = y * y;
    return y * (1.99995452 + y2 * (-0.66524694 + y2 * (0.38708692 + y2 * (-0.23286574 + y2 * (0.10530664 - y2 * 0.0234424)))));
}
