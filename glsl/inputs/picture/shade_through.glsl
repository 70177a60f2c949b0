// A pixel of cloth: what comes through from its other side, but for what goes straight on; and what its yarns mirror.   [own]
#include "core/math.glsl"
#include "inputs/picture/output.glsl"
#ifdef PARTS
#include "inputs/picture/parts.glsl"
#endif
#include "inputs/picture/straight.glsl"
#include "inputs/picture/gbuffer.glsl"
#include "inputs/picture/gbuffer_point.glsl"
#include "behind.glsl"
// Last: a file that is first included where PRINT is not defined would be left out below.
#ifdef PRINT
#include "inputs/picture/print.glsl"
#endif
uniform float pass_weight;  // share of this sample in the pixel
uniform vec3 mirror_albedo;  // what the cloth reflects of even light

const float LEAST_MIRRORED = 1e-4;

void shade(ivec2 pixel) {
    mat3 surface_from_world = surface_from_world_at(pixel);
    vec3 omega_o = surface_from_world * omega_o_at(vec2(pixel) + 0.5);
    omega_o.z = max(omega_o.z, 1e-4);
    vec3 L = L_behind(pixel, omega_o, surface_from_world);
    float R = R_beside(omega_o, k_a, k_t, tau, rho, diffuse, eta_1, eta_2, mirror_albedo);
    vec3 mirrored = vec3(0.0);
    if (R > LEAST_MIRRORED) mirrored = R * L_mirrored(pixel, vec3(-omega_o.xy, omega_o.z), surface_from_world);
#ifdef PRINT
    L *= min(print_mean * print_over_mean(pixel_uv(pixel)), vec3(1.0));
#endif
    float weight = pass_weight * yarns_at(pixel);
    color = vec4((L + mirrored) * weight, 0.0);
#ifdef PARTS
    bounce_color = vec4(0.0);
    through_color = vec4(L * weight, 0.0);
#endif
}
