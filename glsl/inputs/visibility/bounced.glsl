// Light from a ray's hit: a Lambertian's, from the irradiance at the vertices about the hit.
// Needs struct Visit from the pass that includes it; SEVERAL_SURFACES where rays meet more than cloth.
#include "core/math.glsl"
// Defines: FINER, as inputs/visibility/sheets.glsl.
#ifdef FINER
#include "inputs/visibility/coarse.glsl"
#endif
uniform samplerBuffer irradiance_data;  // two a vertex: of the front, of the back
uniform isamplerBuffer corner_index;    // three a triangle, in the order that hits are weighted in
uniform samplerBuffer vertex_data;      // three texels a vertex: position, normal, tangent
uniform int cloth_triangles;     // triangles from here on are no cloth
uniform vec3 radiance_per_irradiance;  // diffuse albedo / pi; 0: no bounce
#ifdef SEVERAL_SURFACES
#include "inputs/visibility/ground_cell.glsl"
#include "inputs/visibility/reflectance.glsl"
uniform int first_of_ground;
uniform bool bounces;

vec3 ground_irradiance(vec3 x) {
    vec4 weights;
    ivec4 corners = ground_cell(x, weights);
    return weights.x * texelFetch(irradiance_data, 2 * corners.x).rgb + weights.y * texelFetch(irradiance_data, 2 * corners.y).rgb
        + weights.z * texelFetch(irradiance_data, 2 * corners.z).rgb + weights.w * texelFetch(irradiance_data, 2 * corners.w).rgb;
}
#endif

// [own]  Radiance that comes back along a ray from `origin`.
vec3 bounced(Visit visit, vec3 origin, vec3 omega) {
#ifdef FINER
    visit = coarse(visit);
#endif
    int t = int(visit.triangle);
#ifdef SEVERAL_SURFACES
    if (!bounces) return vec3(0.0);
    vec3 reflectance = t < cloth_triangles ? radiance_per_irradiance
        : texelFetch(reflectance_data, min(t - cloth_triangles, first_of_ground)).rgb / PI;
    if (visit.triangle == GROUND) return reflectance * ground_irradiance(origin + visit.t * omega);
#else
    if (t >= cloth_triangles || radiance_per_irradiance == vec3(0.0)) return vec3(0.0);
    vec3 reflectance = radiance_per_irradiance;
#endif
    ivec3 corners = ivec3(texelFetch(corner_index, 3 * t).x, texelFetch(corner_index, 3 * t + 1).x,
                          texelFetch(corner_index, 3 * t + 2).x);
    vec3 a = texelFetch(vertex_data, 3 * corners.x).xyz;
    vec3 b = texelFetch(vertex_data, 3 * corners.y).xyz;
    vec3 c = texelFetch(vertex_data, 3 * corners.z).xyz;
    int side = dot(cross(b - a, c - a), omega) < 0.0 ? 0 : 1;
    vec3 E = (1.0 - visit.weights.x - visit.weights.y) * texelFetch(irradiance_data, 2 * corners.x + side).rgb
        + visit.weights.x * texelFetch(irradiance_data, 2 * corners.y + side).rgb
        + visit.weights.y * texelFetch(irradiance_data, 2 * corners.z + side).rgb;
    return E * reflectance;
}
