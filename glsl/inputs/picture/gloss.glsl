// What the pixel of a glossy object shows beside its matt share: `irradiance` of "lit.glsl" adds to it, in programs with GLOSSY.
#include "sg/gloss.glsl"

struct Gloss {
    vec3 omega_o;  // world
    vec3 F_0;      // reflectance at normal incidence
    float alpha;   // roughness squared
};

const float MAP_ALPHA = 0.06;  // of the reference: its directions are a few degrees apart

Gloss gloss;
vec3 L_gloss = vec3(0.0);
