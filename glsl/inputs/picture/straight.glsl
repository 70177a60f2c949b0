// How light passes through the fabric of a draw.   [Mat 1]
#include "woven/sheet.glsl"
#include "inputs/tracing/transmission.glsl"

// The share that a pixel's cloth lets straight on toward omega_o (surface frame): for pictures the one place that says it.
vec3 T_s_at(ivec2 pixel, vec3 omega_o) { return T_straight(omega_o, k_a, k_t, tau, rho, diffuse); }

// How many yarns there are at a pixel, over how many there are in the mean.
float yarns_at(ivec2 pixel) { return 1.0; }
