// Method `reference` with shadows: a ray for every direction of the sum, and what the cloth that it meets sends back.
// Each pass adds `direction_count` directions from `first_direction` on; so no invocation nears a loop limit. Fragments only.
#include "passes/fabric.glsl"
#include "passes/gbuffer_point.glsl"
#include "passes/ray.glsl"
#include "visit.glsl"
#include "accel.glsl"

layout(binding = 10) uniform samplerBuffer direction_data;   // pairs: (omega, 1 if a ray decides), (flux, solid angle)
layout(binding = 11) uniform samplerBuffer irradiance_data;  // two a vertex: of the front, of the back
layout(binding = 12) uniform isamplerBuffer corner_index;    // three a triangle
layout(binding = 13) uniform samplerBuffer vertex_data;      // three texels a vertex: position, normal, tangent
uniform int first_direction;
uniform int direction_count;
uniform int cloth_triangles;     // triangles from here on are no cloth and send nothing back
uniform vec3 radiance_per_irradiance;  // diffuse albedo / pi; 0: no bounce

// [own]  Radiance that the cloth sends back along a ray, as a Lambertian of the fabric's albedo would.
vec3 bounced(Visit visit, vec3 omega) {
    int t = int(visit.triangle);
    if (t >= cloth_triangles || radiance_per_irradiance == vec3(0.0)) return vec3(0.0);
    ivec3 corners = ivec3(texelFetch(corner_index, 3 * t).x, texelFetch(corner_index, 3 * t + 1).x,
                          texelFetch(corner_index, 3 * t + 2).x);
    vec3 a = texelFetch(vertex_data, 3 * corners.x).xyz;
    vec3 b = texelFetch(vertex_data, 3 * corners.y).xyz;
    vec3 c = texelFetch(vertex_data, 3 * corners.z).xyz;
    int side = dot(cross(b - a, c - a), omega) < 0.0 ? 0 : 1;
    vec3 E = (1.0 - visit.weights.x - visit.weights.y) * texelFetch(irradiance_data, 2 * corners.x + side).rgb
        + visit.weights.x * texelFetch(irradiance_data, 2 * corners.y + side).rgb
        + visit.weights.y * texelFetch(irradiance_data, 2 * corners.z + side).rgb;
    return E * radiance_per_irradiance;
}

vec3 L_o(vec3 omega_o, mat3 surface_from_world) {
    vec3 origin = origin_at(ivec2(gl_FragCoord.xy));
    vec3 sum = vec3(0.0);
    for (int d = first_direction; d < first_direction + direction_count; ++d) {
        vec4 direction = texelFetch(direction_data, 2 * d);
        vec3 omega_i = surface_from_world * direction.xyz;
        if (omega_i.z <= 0.0) continue;
        vec4 light = texelFetch(direction_data, 2 * d + 1);
        if (direction.w != 0.0) {
            Visit visit = Visit(3e38, NO_TRIANGLE, vec2(0.0));
            traverse(make_ray(origin, direction.xyz, 0.0, 3e38), visit);
            if (visit.triangle != NO_TRIANGLE) light.rgb = light.a * bounced(visit, direction.xyz);
        }
        if (light.rgb != vec3(0.0)) sum += light.rgb * f_cloth(omega_i, omega_o);
    }
    return sum;
}
