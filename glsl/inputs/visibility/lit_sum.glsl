// Irradiance as the sum over every direction of a cube map and the suns: "lit.glsl" of method reference.
// Each pass adds `direction_count` directions from `first_direction` on.
#include "along.glsl"
uniform samplerBuffer direction_data;   // pairs: (omega, 1 if a ray decides), (flux, solid angle)
uniform int first_direction;
uniform int direction_count;

#ifdef GLOSSY
#include "core/cubemap.glsl"
#include "inputs/picture/gloss.glsl"
uniform mat3 cube_from_world;  // whose texels the directions are
const int MOST_PLACES = 8;     // across a texel
const float LEAST_ROUGHNESS = 0.245;  // a sharper mirror would show the texels

// The mean of f_gloss over the texel of omega_i: seen at a small angle a lobe is much narrower across than a texel is.
vec3 gloss_of_texel(vec3 N, vec3 omega_i, float solid_angle) {
    float alpha = gloss.alpha;
    vec3 both = omega_i + gloss.omega_o;
    float twice = max(length(both), 1e-3);
    float turn = sqrt(solid_angle) / twice;  // of the half vector, from side to side
    float off = length(cross(N, both)) / twice;
    // Far from the mirror's direction the lobe is smooth.
    int places = off > 2.0 * (alpha + turn) ? 1 : int(clamp(ceil(2.0 * turn / alpha), 1.0, float(MOST_PLACES)));
    if (places == 1) return f_gloss(N, omega_i, gloss.omega_o, gloss.F_0, alpha);
    vec3 middle = cube_from_world * omega_i;
    vec3 total = vec3(0.0);
    float weights = 0.0;
    for (int i = 0; i < places * places; ++i) {
        vec2 at = (vec2(i % places, i / places) + 0.5) / float(places) - 0.5;
        vec4 place = in_texel(middle, solid_angle, at);
        total += place.w * f_gloss(N, place.xyz * cube_from_world, gloss.omega_o, gloss.F_0, alpha);
        weights += place.w;
    }
    return total / weights;
}
#endif

vec3 irradiance(ivec2 pixel, vec3 N) {
    vec3 origin = origin_at(pixel);
    vec3 E = vec3(0.0);
    for (int d = first_direction; d < first_direction + direction_count; ++d) {
        vec4 direction = texelFetch(direction_data, 2 * d);
        float cos_theta = dot(direction.xyz, N);
        if (cos_theta <= 0.0) continue;
        vec4 light = texelFetch(direction_data, 2 * d + 1);
        vec3 flux = flux_along(origin, direction, light);
        E += cos_theta * flux;
#ifdef GLOSSY
        L_gloss += flux * gloss_of_texel(N, direction.xyz, light.w) * gloss.repeated;
#endif
#ifdef PARTS
        if (came_back) L_bounce += cos_theta * (flux - let_on);
#endif
#ifdef CATCHER
        if (came_back) E_hidden += cos_theta * (light.rgb - let_on);
#endif
    }
    return E;
}
