// Irradiance from Gaussians and suns, each as far as the pixel sees it, and bounced light: "lit.glsl" of methods direct
// and paper.
#include "inputs/picture/lights.glsl"
#include "inputs/visibility/irradiance_table.glsl"
uniform sampler2DArray seen;       // four values a texel: V_0, V_1 .. V_K, then the suns'
uniform sampler2DArray bounced_light;  // passes/visibility/bounce_pixels.comp
uniform bool everything;  // nothing is hidden
uniform bool bounces;
uniform int sun_number;   // of the first sun's value

float V_number(ivec2 pixel, int n) {
    return everything ? 1.0 : texelFetch(seen, ivec3(pixel, n >> 2), 0)[n & 3];
}

#ifdef GLOSSY
#include "inputs/picture/gloss.glsl"
const float LEAST_ROUGHNESS = 0.0;
const float SUN_ALPHA = 0.02;  // a sun is no point: its image in a mirror is a disk
#endif

vec3 irradiance(ivec2 pixel, vec3 N) {
    vec3 E = vec3(0.0);
    for (int k = 0; k < gaussian_count; ++k) {
        Gaussian light = fetch_gaussian(k);
        E += light.L * (V_number(pixel, 1 + k) * gaussian_irradiance(k, dot(N, light.xi)));
#ifdef GLOSSY
        L_gloss += light.L * (V_number(pixel, 1 + k)
            * gloss_of_gaussian(N, light.xi, light.sharpness, gloss.omega_o, gloss.F_0, gloss.alpha))
            * F_repeated_lobes(gloss.F_0, gloss.albedos, light.sharpness);
#endif
    }
    for (int s = 0; s < sun_count; ++s) {
        Sun sun = fetch_sun(s);
        E += sun.E * (V_number(pixel, sun_number + s) * max(dot(N, sun.omega), 0.0));
#ifdef GLOSSY
        L_gloss += sun.E * (V_number(pixel, sun_number + s)
            * f_gloss(N, sun.omega, gloss.omega_o, gloss.F_0, max(gloss.alpha, SUN_ALPHA))) * gloss.repeated;
#endif
    }
#ifdef CATCHER
    for (int k = 0; k < gaussian_count; ++k) {
        Gaussian light = fetch_gaussian(k);
        E_hidden += light.L * ((1.0 - V_number(pixel, 1 + k)) * gaussian_irradiance(k, dot(N, light.xi)));
    }
    for (int s = 0; s < sun_count; ++s) {
        Sun sun = fetch_sun(s);
        E_hidden += sun.E * ((1.0 - V_number(pixel, sun_number + s)) * max(dot(N, sun.omega), 0.0));
    }
#endif
    if (bounces) E += PI * texelFetch(bounced_light, ivec3(pixel, 0), 0).rgb;
#ifdef GLOSSY
    // What comes from near things comes from everywhere, as far as is known.
    if (bounces) L_gloss += texelFetch(bounced_light, ivec3(pixel, 0), 0).rgb * F_color(gloss.F_0, dot(N, gloss.omega_o));
#endif
#ifdef PARTS
    if (bounces) L_bounce = PI * texelFetch(bounced_light, ivec3(pixel, 0), 0).rgb;
#endif
    return max(E, vec3(0.0));
}
