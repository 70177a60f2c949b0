// Objects that are no cloth: GGX over a Lambertian, as glTF has it, under directions and under spherical Gaussians.   [Walter
// 2007; Wang, Ren, Gong, Snyder, Guo 2009, "All-frequency rendering of dynamic, spatially-varying reflectance"]
// All directions are unit and point away from the surface, in one frame; alpha = roughness^2.
// Twin: glcloth/twins/gloss.py
#include "core/math.glsl"
#include "core/shading_frame.glsl"

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

// Nodes about the middle of a Gaussian: 1 - exp(-x) of its light lies within, and their shares, of Gauss-Laguerre; RING of them
// lie around at each.
const vec2 RINGS[2] = vec2[2](vec2(0.58578644, 0.85355339), vec2(3.41421356, 0.14644661));
const int RING = 5;

// [Wang 2009, Eq. 16, 20; own]  Radiance toward omega_o under a spherical Gaussian of amplitude 1. GGX's normals are three
// Gaussians, which Wang turns to the light's side (sharpness 2 b / alpha^2, spread by 4 |omega_o . N|) and multiplies with the
// light's. A rough surface is far from that: his product only says where nodes lie at which the light and the surface are
// evaluated as they are. Toward a mirror (alpha = 0.04) they draw together and are one.
vec3 gloss_of_gaussian(vec3 N, vec3 xi, float sharpness, vec3 omega_o, vec3 F_0, float alpha) {
    float a2 = max(alpha, ALPHA_LEAST) * max(alpha, ALPHA_LEAST);
    float cos_o = max(dot(N, omega_o), 0.05);
    vec3 mirrored = 2.0 * dot(N, omega_o) * N - omega_o;
    // What reflects 5 % is not worth them either.
    float apart = clamp(20.0 * alpha - 0.8, 0.0, 1.0) * clamp(20.0 * largest(F_0) - 1.0, 0.0, 1.0);
    int count = apart > 0.0 ? 2 * RING : 1;
    vec3 L = vec3(0.0);
    for (int n = 0; n < 3; ++n) {
        float lobe = 0.5 * GGX_LOBES[n].y / (a2 * cos_o);  // 2 b / alpha^2, spread
        vec3 sum = lobe * mirrored + sharpness * xi;
        float both = max(length(sum), 1e-6);
        vec3 way = sum / both;
        float all = 1.0 - exp(-2.0 * both);
        vec3 y = orthogonal_part(cross(N, way), way), x = cross(y, way);
        vec3 total = vec3(0.0);
        for (int k = 0; k < count; ++k) {
            vec2 ring = count == 1 ? vec2(0.0, float(RING)) : RINGS[k / RING];
            // exp(-2 both) is 1 - all.
            float fall = -log(1.0 - (1.0 - exp(-apart * ring.x)) * all);
            float versine = fall / both;
            float r = sqrt(max(versine * (2.0 - versine), 0.0));
            float turn = 2.0 * PI / float(RING) * (float(k) + 0.5 * float(k / RING));
            vec3 omega_i = (1.0 - versine) * way + r * (cos(turn) * x + sin(turn) * y);
            float cos_i = dot(N, omega_i);
            vec3 h = omega_i + omega_o;
            h *= inversesqrt(max(dot(h, h), 1e-12));
            float cos_h = max(dot(N, h), 1e-3);
            vec3 s = cross(N, h), off = omega_i - xi;
            float height = exp(fall - GGX_LOBES[n].y * dot(s, s) / (a2 * cos_h * cos_h) - 0.5 * sharpness * dot(off, off));
            float masked = V_smith(max(cos_i, 0.0), max(dot(N, omega_o), 1e-3), sqrt(a2)) * max(cos_i, 0.0);
            total += F_color(F_0, dot(omega_o, h)) * (ring.y * height * masked / (cos_h * cos_h * cos_h * cos_h));
        }
        L += total * (GGX_LOBES[n].x * 2.0 * all / (float(RING) * both * a2));
    }
    return L;
}

// [own]  What a surface gives back over one reflection, under a Gaussian: for even light what makes a white surface white under
// these lobes, for a narrow one what GGX itself has.
vec3 F_repeated_lobes(vec3 F_0, vec2 albedos, float sharpness) {
    return mix(F_repeated(F_0, albedos.y), F_repeated(F_0, albedos.x), sharpness / (1.0 + sharpness));
}
