// Shadowing-masking M and projected length P of one tangent; their quotient makes the weight W.   [Miz 6]
// Directions are given in the tangent's frame, (omega . t, omega . b, omega . n). Twin: glcloth/twins/weight.py
#include "core/math.glsl"

// [Miz, below 6]  D(x, y, z) = (1 - x) y z + x min(y, z): uncorrelated to correlated masking by x.
float D_mask(float x, float y, float z) {
    return mix(y * z, min(y, z), x);
}

// [Miz, below 6]  D_mask(g(angle between the projections; 0, sigma), max(cos_i, 0), max(cos_o, 0)) for two projected
// directions (sine, cosine times any positive length). Shared by M (in the b-n plane) and P (in the t-n plane).
// Where a projection vanishes its angle is undefined; the cosine 0 then makes the result 0.
float masked(vec2 projected_i, vec2 projected_o, float sigma) {
    float length_i = length(projected_i);
    float length_o = length(projected_o);
    if (min(length_i, length_o) < 1e-9) return 0.0;
    float d = atan(projected_i.x * projected_o.y - projected_i.y * projected_o.x, dot(projected_i, projected_o)) / sigma;
    return D_mask(exp(-d * d), max(projected_i.y / length_i, 0.0), max(projected_o.y / length_o, 0.0));
}

// [Miz, below 6]  M = D(g(phi_d; 0, sigma), max(cos phi_i, 0), max(cos phi_o, 0))
float M(vec3 omega_i, vec3 omega_o, float sigma) {
    return masked(omega_i.yz, omega_o.yz, sigma);
}

// [Miz, below 6]  P = D(g(psi_d; 0, sigma), max(cos psi_i, 0), max(cos psi_o, 0))
float P(vec3 omega_i, vec3 omega_o, float sigma) {
    return masked(omega_i.xz, omega_o.xz, sigma);
}
