// Parts of the paper method's integrals I of one tangent and one Gaussian: Gaussians of theta, and nodes.   [Miz 11-16]
// Twin: glcloth/twins/tangent_integral.py
#include "core/math.glsl"
#include "sg/fresnel_sum.glsl"
#include "sg/gaussian.glsl"

// [Miz 11, 16, 17]  The three Gaussians of theta_i under the integral, of the surface lobe, the volume lobe and the isotropic
// share, each times the environment's: columns mu, sigma, and the factor of `hat_integral`.
mat3 theta_gaussians(float theta_k, float sharpness, float theta_o, float k_d, float gamma_s, float gamma_v) {
    vec3 s = g_c_product(theta_k, sharpness, -theta_o, 0.5 / (gamma_s * gamma_s));
    vec3 v = g_c_product(theta_k, sharpness, -theta_o, 0.5 / (gamma_v * gamma_v));
    vec3 mu = vec3(s.x, v.x, theta_k);
    vec3 sigma = sqrt(2.0 / max(vec3(s.y, v.y, sharpness), vec3(1e-6)));
    vec3 scale = vec3(s.z / gamma_s, (1.0 - k_d) * v.z / gamma_v, k_d * sqrt(PI)) / sqrt(PI) * sigma;
    return mat3(mu, sigma, scale);
}

// [Miz 13-16]  The share of a node theta in (I_s, I_v / A): `weight` of the three Gaussians, times cos^2(theta) /
// cos^2(theta_d), times the sums of F_r cos(phi_d / 2) and of (1 - F_r)^2 over the azimuth; slope is 1 / (cos(theta) +
// cos(theta_o)).
vec2 node_terms(vec3 weight, float cos_theta, float cos_theta_d, float slope, float F_0, vec4 T_1, vec4 T_5, vec4 T_9) {
    float common_factor = cos_theta * cos_theta / max(cos_theta_d * cos_theta_d, 1e-7);
    return common_factor * vec2(weight.x * surface_sum(F_0, cos_theta_d, T_1, T_5),
        (weight.y + weight.z) * slope * volume_sum(F_0, cos_theta_d, T_1, T_5, T_9));
}
