// What comes through cloth from its other side, but for what goes straight on, as the sum over every direction of a cube map
// and the suns: "behind.glsl" of method reference. Each pass adds `direction_count` directions from `first_direction` on.
#include "along.glsl"
#include "core/erf.glsl"
#include "inputs/picture/gbuffer.glsl"
#include "inputs/visibility/origin_behind.glsl"
// Defines: FINER, where suns are hidden by finer triangles.
#ifdef FINER
#include "inputs/visibility/origin_finer.glsl"
#endif
uniform samplerBuffer direction_data;  // pairs: (omega, 1 if a ray decides), (flux, solid angle; 0: of a sun)
uniform int first_direction;
uniform int direction_count;
uniform float mirror_sharpness;        // of a Gaussian over some of them

vec3 L_behind(ivec2 pixel, vec3 omega_o, mat3 surface_from_world) {
    vec3 origin = origin_behind(pixel), o_t = vec3(omega_o.xy, -omega_o.z), sum = vec3(0.0);
#ifdef FINER
    if (own_levels > 0) origin = origin_finer(pixel, -texelFetch(frame_x, pixel, 0).w);
#endif
    for (int d = first_direction; d < first_direction + direction_count; ++d) {
        vec4 direction = texelFetch(direction_data, 2 * d), light = texelFetch(direction_data, 2 * d + 1);
        vec3 omega_i = surface_from_world * direction.xyz;
        if (omega_i.z >= 0.0) continue;
        vec3 i_t = vec3(omega_i.xy, -omega_i.z);
        // What of the map goes straight on is seen through the cloth; a sun is no background.
        vec3 f = light.a > 0.0 ? f_lambert(i_t, o_t, k_t, tau, rho, diffuse) : absorption(i_t, o_t, tau)
            * f_through(i_t, o_t, k_t, rho, roughness, eta_1, eta_2, diffuse, roughness_p);
        sum += f * flux_along(origin, direction, light);
    }
    return sum;
}

// Radiance along omega_i (surface frame, z > 0), as wide as the directions of the sum are apart: those about it, as far as they are
// above the horizon. Suns have their lobes.
vec3 L_mirrored(ivec2 pixel, vec3 omega_i, mat3 surface_from_world) {
    vec3 sum = vec3(0.0);
    float above = 0.5 + 0.5 * erf(omega_i.z * sqrt(0.5 * mirror_sharpness));
    for (int d = first_direction; d < first_direction + direction_count; ++d) {
        vec4 direction = texelFetch(direction_data, 2 * d), light = texelFetch(direction_data, 2 * d + 1);
        vec3 omega = surface_from_world * direction.xyz;
        float x = mirror_sharpness * (1.0 - dot(omega, omega_i));
        if (omega.z <= 0.0 || x > 9.0 || light.a == 0.0) continue;
        sum += exp(-x) * flux_along(origin_at(pixel), direction, light);
    }
    return sum * mirror_sharpness / (2.0 * PI * above);
}
