// Irradiance as the sum over every direction of a cube map and the suns: "lit.glsl" of method reference.
// Each pass adds `direction_count` directions from `first_direction` on.
#include "along.glsl"
uniform samplerBuffer direction_data;   // pairs: (omega, 1 if a ray decides), (flux, solid angle)
uniform int first_direction;
uniform int direction_count;

#ifdef GLOSSY
#include "inputs/picture/gloss.glsl"
#endif

vec3 irradiance(ivec2 pixel, vec3 N) {
    vec3 origin = origin_at(pixel);
    vec3 E = vec3(0.0);
    for (int d = first_direction; d < first_direction + direction_count; ++d) {
        vec4 direction = texelFetch(direction_data, 2 * d);
        float cos_theta = dot(direction.xyz, N);
        if (cos_theta <= 0.0) continue;
        vec3 flux = flux_along(origin, direction, texelFetch(direction_data, 2 * d + 1));
        E += cos_theta * flux;
#ifdef GLOSSY
        L_gloss += flux * f_gloss(N, direction.xyz, gloss.omega_o, gloss.F_0, max(gloss.alpha, MAP_ALPHA)) * gloss.repeated;
#endif
#ifdef PARTS
        if (came_back) L_bounce += cos_theta * (flux - let_on);
#endif
#ifdef CATCHER
        if (came_back) E_hidden += cos_theta * (texelFetch(direction_data, 2 * d + 1).rgb - let_on);
#endif
    }
    return E;
}
