// Sums over the powers of cos(phi_d / 2) that Schlick's Fresnel term expands to.   [Miz 13, 15]
// T_1, T_5, T_9: the integrals T_l of the powers 1-4, 5-8 and 9-12 (those above 10 count for nothing).
// Twin: glcloth/twins/fresnel_sum.py

// [Miz 13-15]  The surface term: F_r cos(phi_d / 2) = sum_l C_l cos(phi_d / 2)^(l + 1), l = 0..5,
//   C_0 = 1, C_l = (1 - F_0) binom(5, l) (-cos theta_d)^l
float surface_sum(float F_0, float cos_theta_d, vec4 T_1, vec4 T_5) {
    float x = -cos_theta_d;
    float tail = x * (5.0 * T_1.y + x * (10.0 * T_1.z + x * (10.0 * T_1.w + x * (5.0 * T_5.x + x * T_5.y))));
    return T_1.x + (1.0 - F_0) * tail;
}

// [own, Miz 13 for the volume term]  F = (1 - F_r)^2 = (1 - F_0)^2 (1 - (1 - y)^5)^2, y = cos(theta_d) cos(phi_d / 2):
// 25 y^2 - 100 y^3 + 200 y^4 - 250 y^5 + 210 y^6 - 120 y^7 + 45 y^8 - 10 y^9 + y^10.
float volume_sum(float F_0, float cos_theta_d, vec4 T_1, vec4 T_5, vec4 T_9) {
    float y = cos_theta_d;
    float high = 210.0 * T_5.y + y * (-120.0 * T_5.z + y * (45.0 * T_5.w + y * (-10.0 * T_9.x + y * T_9.y)));
    float sum = 25.0 * T_1.y + y * (-100.0 * T_1.z + y * (200.0 * T_1.w + y * (-250.0 * T_5.x + y * high)));
    return (1.0 - F_0) * (1.0 - F_0) * y * y * sum;
}
