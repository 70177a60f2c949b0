#version 430
// Radiance that vertices send back, front and back, as Lambertians under Gaussians and suns, each as far as they see it.   [own]
#include "core/math.glsl"
#include "inputs/picture/lights.glsl"
#include "inputs/visibility/irradiance_table.glsl"
// Defines: SHEER, where cloth lets light through.
#include "sight.glsl"
layout(local_size_x = 64) in;
#include "inputs/gpu/item.glsl"
uniform usamplerBuffer mean_data;        // passes/visibility/spread.comp
uniform samplerBuffer vertex_data;       // three texels a vertex: position and normal, each with a lift; tangent
uniform samplerBuffer reflectance_data;  // of these vertices, if `own_reflectance`
layout(std430) writeonly buffer Radiance { vec4 radiance[]; };  // of a vertex front and back
uniform int first_item;                  // vertex
uniform int vertex_count;                // from there on, and from the beginning of mean_data and reflectance_data
uniform int group_count;
uniform float offset;                    // how far from the vertex rays start, beyond its own lift
uniform bool own_reflectance;
uniform vec3 reflectance;                // else
uniform vec3 passed;                     // what of the other side's light comes evenly through

void main() {
    int i = item();
    if (i >= vertex_count) return;
    vec4 x = texelFetch(vertex_data, 3 * (first_item + i));
    vec4 N = texelFetch(vertex_data, 3 * (first_item + i) + 1);
    vec3 front = vec3(0.0), back = front;
    for (int k = 0; k < gaussian_count; ++k) {
        Gaussian light = fetch_gaussian(k);
        float cos_theta = dot(N.xyz, light.xi);
        int group = (1 + k) >> 2, at = (1 + k) & 3;
        float V = unpackUnorm4x8(texelFetch(mean_data, 2 * i * group_count + group).x)[at];
        float V_back = unpackUnorm4x8(texelFetch(mean_data, (2 * i + 1) * group_count + group).x)[at];
        front += light.L * (V * gaussian_irradiance(k, cos_theta));
        back += light.L * (V_back * gaussian_irradiance(k, -cos_theta));
    }
    for (int s = 0; s < sun_count; ++s) {
        Sun sun = fetch_sun(s);
        float cos_theta = dot(N.xyz, sun.omega);
        vec3 origin = x.xyz + (cos_theta < 0.0 ? -offset - N.w : offset + x.w) * N.xyz;
#ifdef SHEER
        Visit first;
        sun.E *= left_along(origin, sun.omega, first);
#else
        Visit visit = Visit(3e38, NO_TRIANGLE, vec2(0.0));
        traverse(make_ray(origin, sun.omega, 0.0, 3e38), visit);
        if (visit.t == 0.0) continue;
#endif
        front += sun.E * max(cos_theta, 0.0);
        back += sun.E * max(-cos_theta, 0.0);
    }
    vec3 share = (own_reflectance ? texelFetch(reflectance_data, i).rgb : reflectance) / PI;
    front = max(front, vec3(0.0));
    back = max(back, vec3(0.0));
#ifdef SHEER
    vec3 through = passed / PI;
    radiance[2 * (first_item + i)] = vec4(share * front + through * back, 0.0);
    radiance[2 * (first_item + i) + 1] = vec4(share * back + through * front, 0.0);
#else
    radiance[2 * (first_item + i)] = vec4(share * front, 0.0);
    radiance[2 * (first_item + i) + 1] = vec4(share * back, 0.0);
#endif
}
