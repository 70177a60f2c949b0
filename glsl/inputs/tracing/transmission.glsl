// How light passes through the fabric of a draw.   [Mat 1]
#include "woven/sheet.glsl"

#ifdef FABRICS
#include "inputs/tracing/fabrics.glsl"
#else
uniform float rho;
uniform float k_a;
uniform float k_t;
uniform vec3 tau;
uniform float diffuse;
uniform float roughness;
uniform float eta_1;
uniform float eta_2;
uniform float roughness_p;
#endif
