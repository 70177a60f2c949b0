// What the pixel of a glossy object shows beside its matt share: `irradiance` of "lit.glsl" adds to it, in programs with GLOSSY.
#include "sg/gloss.glsl"

struct Gloss {
    vec3 omega_o;  // world
    vec3 F_0;      // reflectance at normal incidence
    float alpha;   // roughness squared
    vec2 albedos;  // shares of even light that leave after one reflection: of GGX, and of its lobes under Gaussians
    vec3 repeated;  // what light from a direction gains that is reflected more than once
};
uniform sampler2D gloss_albedo;  // of cos_o = t^2 and the roughness: both shares, see glcloth/picture/looks.py

// The gloss of a surface seen from omega_o.
Gloss gloss_from(vec3 N, vec3 omega_o, vec3 F_0, float roughness) {
    vec2 size = vec2(textureSize(gloss_albedo, 0));
    vec2 at = vec2(sqrt(clamp(dot(N, omega_o), 0.0, 1.0)), roughness);
    vec2 albedo = textureLod(gloss_albedo, (at * (size - 1.0) + 0.5) / size, 0.0).rg;
    return Gloss(omega_o, F_0, roughness * roughness, albedo, F_repeated(F_0, albedo.x));
}

Gloss gloss;
vec3 L_gloss = vec3(0.0);
