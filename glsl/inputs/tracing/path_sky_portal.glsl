// The light from far away as a room sees it: a map without its suns, drawn by points of the rectangles that it shines in
// through.
#include "core/equirect.glsl"
uniform sampler2D sky_map;
uniform samplerBuffer portal_data;  // of each (corner, share of those up to it), (side u, its share), (side v, -)
uniform int portal_count;
uniform mat3 environment_from_world;

// Radiance, and the density of `sky_direction` per solid angle.
vec3 sky_radiance(vec3 from, vec3 omega, out float pdf) {
    pdf = 0.0;
    int k = 0;
    do {
        vec4 u = texelFetch(portal_data, 3 * k + 1);
        vec3 v = texelFetch(portal_data, 3 * k + 2).xyz, corner = texelFetch(portal_data, 3 * k).xyz, n = cross(u.xyz, v);
        float toward = dot(omega, n);
        float t = dot(corner - from, n) / (abs(toward) < 1e-12 ? 1e-12 : toward);
        vec3 q = from + t * omega - corner;
        vec2 at = vec2(dot(q, cross(v, n)), dot(q, cross(n, u.xyz))) / dot(n, n);
        bool met = t > 0.0 && all(greaterThanEqual(at, vec2(0.0))) && all(lessThanEqual(at, vec2(1.0)));
        pdf += met ? u.w * t * t / max(abs(toward), 1e-12) : 0.0;
    } while (++k < portal_count);
    return textureLod(sky_map, uv_from_direction(normalize(environment_from_world * omega)), 0.0).rgb;
}

// By a number that chooses, and two that place.
vec3 sky_direction(vec3 from, vec2 choice, vec2 place) {
    int k = 0;
    while (k + 1 < portal_count && choice.x >= texelFetch(portal_data, 3 * k).w) ++k;
    vec3 u = texelFetch(portal_data, 3 * k + 1).xyz, v = texelFetch(portal_data, 3 * k + 2).xyz;
    return normalize(texelFetch(portal_data, 3 * k).xyz + place.x * u + place.y * v - from);
}
