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

// [own]  omega . t and omega . n of a direction that lies `along` the yarn and z above the surface.
mat2x4 tangent_slots(vec4 along, float z, vec4 cos_tilt, vec4 sin_tilt) {
    return mat2x4(along * cos_tilt - z * sin_tilt, along * sin_tilt + z * cos_tilt);
}

// [own]  theta of a direction by sin(theta) = omega . t.
vec4 theta_slots(vec4 t) {
    vec4 c2 = max(1.0 - t * t, 1e-7);
    return twice_atan(t / (1.0 + c2 * inversesqrt(c2)));
}

// [Miz 4]  The lobe of a rule's node: a Gaussian of theta_i whose exponent is the square of start + slope theta_i.
vec4 lobe_slots(vec4 theta_i, vec4 start, vec4 slope) {
    vec4 x = start + slope * theta_i;
    return exp2(-x * x);
}

// [Miz 5-6, 12]  Inputs of the terms of f_s and W from two directions: columns M, F_r, cos(phi_d / 2) / 2,
// 4 cos^2(theta_d). No term needs a clamp at its tangent's horizon, where P vanishes.
mat4 scatter_slots(vec4 t, vec4 cos_theta_i, vec4 cos_phi_i, vec4 cos_phi_d, vec4 sin_theta_o, vec4 cos_theta_o, vec4 cos_phi_o,
                   vec4 F_0, vec4 series) {
    vec4 M = D_masks(g_of_cos(cos_phi_d, series), cos_phi_i, cos_phi_o);
    vec4 half_cos_half_phi_d = sqrt(max(0.125 + 0.125 * cos_phi_d, 0.0));
    vec4 cos_sum = cos_theta_i + cos_theta_o, sin_sum = t + sin_theta_o;
    vec4 cos2_theta_d_4 = cos_sum * cos_sum + sin_sum * sin_sum;
    vec4 F_r = F_slots(F_0, sqrt(cos2_theta_d_4), half_cos_half_phi_d);
    return mat4(M, F_r, half_cos_half_phi_d, cos2_theta_d_4);
}
