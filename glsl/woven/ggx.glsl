// Microfacets after Trowbridge and Reitz (GGX).   [Mat 2-5; Walter, Marschner, Li, Torrance 2007, "Microfacet models for
// refraction through rough surfaces"]
// Directions are unit and point away from the sheet, in a frame with z = N; omega_i.z > 0 is the light's side. `h` is the
// half vector, turned to the light's side; eta_1 is the index on the light's side, eta_2 on the viewer's.
// Twin: glcloth/twins/ggx.py
#include "core/math.glsl"
#include "core/fresnel.glsl"

// [Mat 5, erratum E3]  D = r^2 / (pi cos^4 theta_nh (r^2 + tan^2 theta_nh)^2), with r = roughness
// By the sine of theta_nh instead of 1 - cos^2, which has no digits left for a sharp lobe.
float D_GGX(vec3 h, float roughness) {
    if (h.z <= 0.0) return 0.0;
    float r2 = roughness * roughness;
    float q = r2 * h.z * h.z + dot(h.xy, h.xy);
    return r2 / (PI * q * q);
}

// [Walter 2007, Eq. 34]  G_1 = 2 / (1 + sqrt(1 + r^2 tan^2 theta)): Smith's shadowing of GGX toward one direction
float G_1_smith(vec3 omega, float roughness) {
    float z2 = omega.z * omega.z;
    return 2.0 * abs(omega.z) / max(abs(omega.z) + sqrt(z2 + roughness * roughness * dot(omega.xy, omega.xy)), 1e-12);
}

// [Mat 4]  Schlick's Fresnel reflectance between two media. From the denser side it takes the cosine of the refracted
// ray, and is 1 beyond the critical angle.
float F_interface(float cos_lh, float eta_1, float eta_2) {
    float r = (eta_1 - eta_2) / (eta_1 + eta_2);
    float cosine = cos_lh;
    if (eta_1 > eta_2) {
        float ratio = eta_1 / eta_2;
        float cos2_t = 1.0 - ratio * ratio * (1.0 - cos_lh * cos_lh);
        if (cos2_t <= 0.0) return 1.0;
        cosine = sqrt(cos2_t);
    }
    return F_schlick(r * r, min(cosine, 1.0));
}

// [Walter 2007, Eq. 16]  h_t = -(eta_1 omega_i + eta_2 omega_o), turned to the light's side; its length, which Eq. 2 of
// paper B needs too, is kept (.w). Zero where no facet refracts omega_i into omega_o.
vec4 h_t(vec3 omega_i, vec3 omega_o, float eta_1, float eta_2) {
    vec3 h = -(eta_1 * omega_i + eta_2 * omega_o);
    float size = length(h);
    if (size < 1e-6) return vec4(0.0);
    h *= (h.z < 0.0 ? -1.0 : 1.0) / size;
    float cos_lh = dot(omega_i, h);
    float cos_vh = dot(omega_o, h);
    return cos_lh > 0.0 && cos_vh < 0.0 ? vec4(h, size) : vec4(0.0);
}

// [Mat 2, errata E5, E9; Walter 2007, Eq. 21]  The BTDF of a rough interface:
//   f_GGX = cos_lh cos_vh / (cos_nl cos_nv) eta_2^2 (1 - F) G D / (eta_1 cos_lh + eta_2 cos_vh)^2
// with signed cosines in the denominator, which then is |h_t|^2, and magnitudes elsewhere. G is Smith's, because with the
// cavities of equation 3 the lobe gains energy at grazing light. Unit 1/sr; 0 unless the two are on opposite sides.
float f_GGX(vec3 omega_i, vec3 omega_o, float roughness, float eta_1, float eta_2) {
    if (omega_i.z <= 0.0 || omega_o.z >= 0.0) return 0.0;
    vec4 h = h_t(omega_i, omega_o, eta_1, eta_2);
    if (h.w == 0.0) return 0.0;
    float cos_lh = dot(omega_i, h.xyz);
    float cos_vh = -dot(omega_o, h.xyz);
    float G = G_1_smith(omega_i, roughness) * G_1_smith(omega_o, roughness);
    float q = eta_2 / h.w;
    return cos_lh * cos_vh / (omega_i.z * -omega_o.z) * q * q * (1.0 - F_interface(cos_lh, eta_1, eta_2)) * G
           * D_GGX(h.xyz, roughness);
}

// [own]  A lobe about the straight-through direction, for light that passes the yarn without refracting: the reflection
// lobe D G / (4 cos_nl cos_nv) of Walter 2007, Eq. 20, without Fresnel, seen through the sheet (omega_o.z < 0). One
// interface between different media (Eq. 2 of paper B) would lean toward the normal; between equal ones it is a delta.
float f_straight(vec3 omega_i, vec3 omega_o, float roughness) {
    if (omega_i.z <= 0.0 || omega_o.z >= 0.0) return 0.0;
    vec3 h = normalize(omega_i + vec3(omega_o.xy, -omega_o.z));
    float G = G_1_smith(omega_i, roughness) * G_1_smith(omega_o, roughness);
    return D_GGX(h, roughness) * G / (4.0 * omega_i.z * -omega_o.z);
}
