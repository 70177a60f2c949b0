// As inputs/picture/straight.glsl, for which it stands where pixels show threads: holes are where the maps have them.   [own]
#include "inputs/methods/weave.glsl"
#include "inputs/tracing/transmission.glsl"
#include "woven/sheet.glsl"

vec3 T_s_at(ivec2 pixel, vec3 omega_o) {
    return T_sheet_at(omega_o, k_a, k_t * (1.0 - 0.5 * diffuse), tau, rho, hole_share(pixel), hole_mean);
}

float yarns_at(ivec2 pixel) { return (1.0 - hole_share(pixel)) / max(1.0 - hole_mean, 1e-6); }
