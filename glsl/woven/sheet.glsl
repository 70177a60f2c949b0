// A sheet of woven cloth: holes between the yarns, and light through the yarns.   [Mat 1]
// Directions are unit and point away from the sheet, in the surface frame: x = yarn 1, y = yarn 2, z = N.
//   L_out = k_a T_open L_direct + covered k_t exp(-tau') f_yarn E cos_nl,   covered = 1 - T_open, rho at normal incidence
// Twin: glcloth/twins/sheet.py
#include "core/math.glsl"
#include "woven/ggx.glsl"

// [own]  The share of light along omega that meets no yarn: 1 - rho at normal incidence, less at a slant, because the
// round yarns of each family cover their gaps: max(0, 1 - q / cos a) max(0, 1 - q / cos b), q = diameter / pitch, a and b
// the angles to N in the planes across yarn 1 and across yarn 2.
float T_open(vec3 omega, float rho) {
    float q = 1.0 - sqrt(max(1.0 - rho, 0.0));
    vec2 open = max(abs(omega.z) - q * vec2(length(omega.yz), length(omega.xz)), 0.0);
    return open.x * open.y / max(omega.z * omega.z, 1e-12);
}

// [own]  The share of light that meets no yarn where `hole` of the place is a hole, `mean` of the whole cloth is, and `open` of
// all light meets none. It is between 0 and 1 and straight in `hole`, so its mean over the cloth is `open`.
float open_at(float open, float hole, float mean) {
    return open <= mean ? open * hole / max(mean, 1e-6) : 1.0 - (1.0 - open) * (1.0 - hole) / max(1.0 - mean, 1e-6);
}

// [own]  The share of the yarns' term: symmetric in the two directions, and with the holes it never exceeds 1 for either.
float covered(vec3 omega_i, vec3 omega_o, float rho) {
    return 1.0 - max(T_open(omega_i, rho), T_open(omega_o, rho));
}

// [Mat 1]  exp(-tau) along the slanted way: half of the layer along omega_i, half along omega_o. The cosines are kept
// from 0 because a yarn is round: no way through it is longer than about ten times the thinnest.
vec3 absorption(vec3 omega_i, vec3 omega_o, vec3 tau) {
    float ways = 0.5 / max(abs(omega_i.z), 0.1) + 0.5 / max(abs(omega_o.z), 0.1);
    return exp(-tau * ways);
}

// [Mat 1]  One unit of light through the yarns: 1/2 f_t + 1/2 f_p, the diffuse and the directed transmission.
//   f_t = (1 - diffuse) f_GGX(roughness, eta_1, eta_2) + diffuse / pi,   f_p = f_straight(roughness_p)
// The Lambertian share is ours: one interface bends light by a few degrees only.
float f_yarn(vec3 omega_i, vec3 omega_o, float roughness, float eta_1, float eta_2, float diffuse, float roughness_p) {
    if (omega_i.z <= 0.0 || omega_o.z >= 0.0) return 0.0;
    float f_t = mix(f_GGX(omega_i, omega_o, roughness, eta_1, eta_2), 1.0 / PI, diffuse);
    return 0.5 * f_t + 0.5 * f_straight(omega_i, omega_o, roughness_p);
}

// [Mat 1]  The yarns' term without its absorption: covered k_t f_yarn cos_nl, light from omega_i toward omega_o behind.
float f_through(vec3 omega_i, vec3 omega_o, float k_t, float rho, float roughness, float eta_1, float eta_2, float diffuse,
                float roughness_p) {
    return covered(omega_i, omega_o, rho) * k_t * max(omega_i.z, 0.0)
           * f_yarn(omega_i, omega_o, roughness, eta_1, eta_2, diffuse, roughness_p);
}

// [Mat 1]  The part of a ray that goes on straight: k_a T_open + (1 - T_open) k exp(-tau'). For a ray to the eye k = k_t;
// for a ray to the lamp k = k_t / 2, the half that does not refract.
vec3 T_sheet(vec3 omega, float k_a, float k, vec3 tau, float rho) {
    float open = T_open(omega, rho);
    return k_a * open + (1.0 - open) * k * absorption(omega, omega, tau);
}

// [own]  The same at a place of which `hole` is a hole; `mean`: of the whole cloth.
vec3 T_sheet_at(vec3 omega, float k_a, float k, vec3 tau, float rho, float hole, float mean) {
    float open = open_at(T_open(omega, rho), hole, mean);
    return k_a * open + (1.0 - open) * k * absorption(omega, omega, tau);
}

// [own]  The part of a ray that the yarns mirror: (1 - T_open) (1 - k_t) F(cos); with T_sheet it never exceeds 1.
float R_sheet(vec3 omega, float k_t, float rho, float eta_1, float eta_2) {
    return (1.0 - T_open(omega, rho)) * (1.0 - k_t) * F_interface(abs(omega.z), eta_1, eta_2);
}

// [own]  What is mirrored, R, at most what the light that passes, T, and the fabric's albedo leave: toward the horizon yarns
// mirror nearly all, and the fabric's reflection holds such light already.
float R_limited(float R, vec3 T, vec3 albedo) {
    vec3 left = 1.0 - T - albedo;
    return clamp(min(left.r, min(left.g, left.b)), 0.0, R);
}

// [own]  The share of light, coming evenly from a half space, that a layer of optical depth 2 x lets through where x is the
// depth of the half that it comes from: 2 E_3(x), fitted within 0.5 % where a hundredth passes.
float diffuse_transmittance(float x) {
    return exp(-x * (1.0 + 1.0 / (1.0 + 0.934 * pow(max(x, 0.0), 0.665))));
}

// [own]  The Lambertian share of the yarns' term of one light: covered k_t exp(-tau) cos_nl diffuse / (2 pi), from omega_i
// toward omega_o behind.
vec3 f_lambert(vec3 omega_i, vec3 omega_o, float k_t, vec3 tau, float rho, float diffuse) {
    if (omega_i.z <= 0.0 || omega_o.z >= 0.0) return vec3(0.0);
    return covered(omega_i, omega_o, rho) * k_t * omega_i.z * diffuse / (2.0 * PI) * absorption(omega_i, omega_o, tau);
}

// [own]  The energy split of all that passes. Straight on: the holes, and of the yarns what is not Lambertian, whose lobes
// stay within some ten degrees of the ray: k_a T_open + (1 - T_open) k_t exp(-tau') (1 - diffuse / 2).
vec3 T_straight(vec3 omega, float k_a, float k_t, vec3 tau, float rho, float diffuse) {
    return T_sheet(omega, k_a, k_t * (1.0 - 0.5 * diffuse), tau, rho);
}

// [own]  The larger T_open of omega and of a direction of even light, in the mean over its half space, by its cosines:
// sqrt(1 - rho) of the largest where no hole is open along omega, all of it where omega is normal; in between fitted
// within 0.02.
float holes_of_even_light(float open, float rho) {
    float most = max(1.0 - rho, 1e-6);
    float s = sqrt(most);
    return most * mix(s, 1.0, pow(min(open / most, 1.0), 1.0 / (1.0 - 0.78 * s)));
}

// [own]  And evenly: the radiance toward omega is T_lambert E / pi, E the irradiance of the other side. It is the integral of
// f_lambert over even light.
vec3 T_lambert(vec3 omega, float k_t, vec3 tau, float rho, float diffuse) {
    vec3 light = vec3(diffuse_transmittance(0.5 * tau.r), diffuse_transmittance(0.5 * tau.g), diffuse_transmittance(0.5 * tau.b));
    return (1.0 - holes_of_even_light(T_open(omega, rho), rho)) * k_t * 0.5 * diffuse * light
        * exp(-0.5 * tau / max(abs(omega.z), 0.1));
}

// [own]  What a layer mirrors toward omega of the light of one direction, where it reflects `albedo` of even light.
float R_beside(vec3 omega, float k_a, float k_t, vec3 tau, float rho, float diffuse, float eta_1, float eta_2, vec3 albedo) {
    vec3 T = T_straight(omega, k_a, k_t, tau, rho, diffuse) + T_lambert(omega, k_t, tau, rho, diffuse);
    return R_limited(R_sheet(omega, k_t, rho, eta_1, eta_2), T, albedo);
}
