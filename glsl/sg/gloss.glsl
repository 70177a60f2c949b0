// Objects that are no cloth: GGX over a Lambertian, as glTF has it, under directions and under spherical Gaussians.   [Walter
// 2007; Wang, Ren, Gong, Snyder, Guo 2009, "All-frequency rendering of dynamic, spatially-varying reflectance"]
// All directions are unit and point away from the surface, in one frame; alpha = roughness^2.
// Twin: glcloth/twins/gloss.py
#include "core/math.glsl"

const float ALPHA_LEAST = 2e-3;  // a mirror, as far as float32 and Gaussians go

// [Heitz 2014, Eq. 99]  G_2 / (4 cos_i cos_o) of GGX, with Smith's shadowing and masking correlated by height.
float V_smith(float cos_i, float cos_o, float alpha) {
    float a2 = alpha * alpha;
    float i = cos_o * sqrt(a2 + (1.0 - a2) * cos_i * cos_i);
    float o = cos_i * sqrt(a2 + (1.0 - a2) * cos_o * cos_o);
    return 0.5 / max(i + o, 1e-6);
}

// [Schlick 1994]  F_0 + (1 - F_0) (1 - cos_theta)^5, of colours
vec3 F_color(vec3 F_0, float cos_theta) {
    return F_0 + (vec3(1.0) - F_0) * pow5(1.0 - clamp(cos_theta, 0.0, 1.0));
}

// [Turquin 2019, "Practical multiple scattering compensation for microfacet models", Eq. 16]  What a rough surface gives back
// over what it does after one reflection, of which a share `albedo` leaves where F is 1.
vec3 F_repeated(vec3 F_0, float albedo) {
    return vec3(1.0) + F_0 * (1.0 / max(albedo, 1e-3) - 1.0);
}

// [Walter 2007, Eq. 20, 33]  f_r cos_i of GGX with reflectance F_0 at normal incidence: radiance toward omega_o per
// irradiance perpendicular to light from omega_i. The half vector's sine, not 1 - cos^2, which has no digits for a mirror.
vec3 f_gloss(vec3 N, vec3 omega_i, vec3 omega_o, vec3 F_0, float alpha) {
    float cos_i = dot(N, omega_i);
    float cos_o = max(dot(N, omega_o), 1e-3);
    if (cos_i <= 0.0) return vec3(0.0);
    vec3 h = omega_i + omega_o;
    h *= inversesqrt(max(dot(h, h), 1e-12));
    float a = max(alpha, ALPHA_LEAST);
    float cos_h = dot(N, h);
    vec3 s = cross(N, h);
    float q = a * a * cos_h * cos_h + dot(s, s);
    float D = a * a / (PI * q * q);
    return F_color(F_0, dot(omega_o, h)) * (D * V_smith(cos_i, cos_o, a) * cos_i);
}

// GGX's 1 / (1 + u)^2, u = (tan theta / alpha)^2, as a sum of c exp(-b u): (c, b). Its tail is what makes it GGX.   [own fit,
// 3 % of the peak at most, its integral to 2e-4]
const vec2 GGX_LOBES[3] = vec2[3](vec2(0.60319418, 2.61482955), vec2(0.36280869, 0.70543652), vec2(0.02762133, 0.10839955));

// [Wang 2009, Eq. 16, 20]  Radiance toward omega_o under a spherical Gaussian of amplitude 1: GGX's normals as Gaussians of
// sharpness 2 b / alpha^2, turned to the light's side, times the light's; the rest of the product where that is largest.
vec3 gloss_of_gaussian(vec3 N, vec3 xi, float sharpness, vec3 omega_o, vec3 F_0, float alpha) {
    float a2 = max(alpha, ALPHA_LEAST) * max(alpha, ALPHA_LEAST);
    float cos_o = max(dot(N, omega_o), 0.05);
    vec3 mirrored = 2.0 * dot(N, omega_o) * N - omega_o;
    vec3 L = vec3(0.0);
    for (int n = 0; n < 3; ++n) {
        float lobe = 0.5 * GGX_LOBES[n].y / (a2 * cos_o);  // 2 b / alpha^2, spread by 4 |omega_o . N|
        vec3 sum = lobe * mirrored + sharpness * xi;
        float both = length(sum);
        vec3 way = sum / max(both, 1e-6);
        // exp(both - lobe - sharpness), whose terms are large and nearly equal
        float lost = lobe * sharpness * dot(mirrored - xi, mirrored - xi) / max(both + lobe + sharpness, 1e-6);
        float product = 2.0 * PI * (1.0 - exp(-2.0 * both)) / max(both, 1e-6) * exp(-lost);
        float cos_i = max(dot(N, way), 0.0);
        vec3 h = way + omega_o;
        float cos_h = dot(omega_o, h) * inversesqrt(max(dot(h, h), 1e-12));
        float shape = V_smith(cos_i, max(dot(N, omega_o), 1e-3), sqrt(a2)) * cos_i / (PI * a2);
        L += F_color(F_0, cos_h) * (GGX_LOBES[n].x * product * shape);
    }
    return L;
}
