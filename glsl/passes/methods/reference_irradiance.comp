#version 430
// Irradiance at the vertices of the cloth and the objects, on both sides, from the directions that no triangle hides:
// `direction_count` of them from `first_direction` on are added.
// Defines: SHEER, where cloth lets light through.
#include "sight.glsl"
layout(local_size_x = 64) in;
#include "inputs/gpu/item.glsl"
uniform samplerBuffer direction_data;  // pairs: (omega, -), (flux, -)
uniform samplerBuffer vertex_data;     // three texels a vertex: position and normal, each with a lift; tangent
layout(std430) buffer Irradiance { vec4 irradiance[]; };  // two a vertex: of the front, of the back
uniform int vertex_count;
uniform int first_direction;
uniform int direction_count;
uniform float offset;  // how far from the vertex rays start, metres

void main() {
    int i = item();
    if (i >= vertex_count) return;
    vec4 position = texelFetch(vertex_data, 3 * i);
    vec4 N = texelFetch(vertex_data, 3 * i + 1);
    vec3 front = vec3(0.0);
    vec3 back = vec3(0.0);
    for (int d = first_direction; d < first_direction + direction_count; ++d) {
        vec3 omega = texelFetch(direction_data, 2 * d).xyz;
        vec3 flux = texelFetch(direction_data, 2 * d + 1).rgb;
        float cos_theta = dot(omega, N.xyz);
        vec3 origin = position.xyz + (cos_theta < 0.0 ? -offset - N.w : offset + position.w) * N.xyz;
#ifdef SHEER
        Visit first;
        flux *= left_along(origin, omega, first);
#else
        Visit visit = Visit(3e38, NO_TRIANGLE, vec2(0.0));
        traverse(make_ray(origin, omega, 0.0, 3e38), visit);
        if (visit.triangle != NO_TRIANGLE) continue;
#endif
        front += flux * max(cos_theta, 0.0);
        back += flux * max(-cos_theta, 0.0);
    }
    irradiance[2 * i].rgb += front;
    irradiance[2 * i + 1].rgb += back;
}
