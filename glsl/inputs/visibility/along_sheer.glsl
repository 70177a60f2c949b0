// As inputs/visibility/along_ray.glsl, where cloth lets light through: each sheet on the way sends back what it reflects and
// what comes evenly through it, and lets on what is behind.
#include "inputs/visibility/sheets.glsl"
#include "inputs/visibility/bounced.glsl"
uniform bool light_behind;  // whether sheets send on the light of their other side

// Irradiance of the side of a sheet that looks away from the ray.
vec3 irradiance_behind(Visit visit, vec3 omega) {
#ifdef FINER
    visit = coarse(visit);
#endif
    int t = int(visit.triangle);
    ivec3 corners = ivec3(texelFetch(corner_index, 3 * t).x, texelFetch(corner_index, 3 * t + 1).x,
                          texelFetch(corner_index, 3 * t + 2).x);
    vec3 a = texelFetch(vertex_data, 3 * corners.x).xyz;
    int side = dot(cross(texelFetch(vertex_data, 3 * corners.y).xyz - a, texelFetch(vertex_data, 3 * corners.z).xyz - a), omega)
        < 0.0 ? 1 : 0;
    return (1.0 - visit.weights.x - visit.weights.y) * texelFetch(irradiance_data, 2 * corners.x + side).rgb
        + visit.weights.x * texelFetch(irradiance_data, 2 * corners.y + side).rgb
        + visit.weights.y * texelFetch(irradiance_data, 2 * corners.z + side).rgb;
}

// `direction.w` is 1 where a ray decides; `light` is flux and solid angle.
vec3 flux_along(vec3 origin, vec4 direction, vec4 light) {
#if defined(PARTS) || defined(CATCHER)
    came_back = false;
    let_on = vec3(0.0);
#endif
    if (direction.w == 0.0) return light.rgb;
    vec3 T = vec3(1.0), back = vec3(0.0);
    float from = 0.0;
    int n = 0;
    do {
        Visit visit = Visit(3e38, NO_TRIANGLE, vec2(0.0));
        traverse(make_ray(origin, direction.xyz, from, 3e38), visit);
#if defined(PARTS) || defined(CATCHER)
        came_back = n > 0 || visit.triangle != NO_TRIANGLE;
        let_on = n > 0 && visit.triangle == NO_TRIANGLE ? T * light.rgb : vec3(0.0);
#endif
        if (visit.triangle == NO_TRIANGLE) return T * light.rgb + light.a * back;
        back += T * bounced(visit, origin, direction.xyz);
        Sheet sheet = sheet_at(visit, direction.xyz);
        if (sheet.number >= 0 && light_behind) {
            back += T * T_lambert_of(sheet) / PI * irradiance_behind(visit, direction.xyz);
        }
        T *= T_s_of(sheet);
        from = behind_layer(visit.t);
    } while (worth(T) && ++n < MOST_LAYERS);
    return light.a * back;
}
