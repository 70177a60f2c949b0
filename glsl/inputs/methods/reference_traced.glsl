// Method `reference` with shadows: a ray for every direction of the sum, and what it meets sends back.
// Each pass adds `direction_count` directions from `first_direction` on; so no invocation nears a loop limit. Of pixels only: `shaded_pixel`.
#include "inputs/picture/fabric.glsl"
#include "inputs/picture/gbuffer.glsl"
#include "inputs/picture/gbuffer_point.glsl"
#include "inputs/visibility/along_ray.glsl"
// Defines: FINER, where suns are hidden by finer triangles.
#ifdef FINER
#include "inputs/visibility/origin_finer.glsl"
#endif

uniform samplerBuffer direction_data;   // pairs: (omega, 1 if a ray decides), (flux, solid angle)
uniform int first_direction;
uniform int direction_count;

vec3 L_o(vec3 omega_o, mat3 surface_from_world) {
    vec3 origin = origin_at(shaded_pixel);
#ifdef FINER
    if (own_levels > 0) origin = origin_finer(shaded_pixel, texelFetch(frame_x, shaded_pixel, 0).w);
#endif
    vec3 sum = vec3(0.0);
    for (int d = first_direction; d < first_direction + direction_count; ++d) {
        vec4 direction = texelFetch(direction_data, 2 * d);
        vec3 omega_i = surface_from_world * direction.xyz;
        if (omega_i.z <= 0.0) continue;
        vec3 flux = flux_along(origin, direction, texelFetch(direction_data, 2 * d + 1));
        if (flux == vec3(0.0)) continue;
        vec3 f = f_cloth(omega_i, omega_o);
        sum += flux * f;
#ifdef PARTS
        if (came_back) L_bounce += (flux - let_on) * f;
#endif
    }
    return sum;
}
