#version 430
// Radiance that vertices send back, front and back, evenly under Gaussians and suns, each as far as they see it.   [own]
#include "core/math.glsl"
#include "inputs/picture/lights.glsl"
#include "inputs/visibility/irradiance_table.glsl"
#include "trace/visibility.glsl"
// Defines: SHEER, where cloth lets light through.
#include "sight.glsl"
layout(local_size_x = 64) in;
#include "inputs/gpu/item.glsl"
uniform usamplerBuffer mean_data;        // passes/visibility/spread.comp
uniform samplerBuffer vertex_data;       // three texels a vertex: position and normal, each with a lift; tangent
uniform samplerBuffer reflectance_data;  // of these vertices, if `own_reflectance`
layout(std430) writeonly buffer Radiance { vec4 radiance[]; };  // of a vertex front and back; how upright it is
uniform int first_item;                  // vertex
uniform int vertex_count;                // from there on, and from the beginning of mean_data and reflectance_data
uniform int group_count;
uniform float offset;                    // how far from the vertex rays start, beyond its own lift
uniform bool own_reflectance;
uniform vec3 reflectance;                // else
uniform float flat_share, upright, upright_of_height;  // of what they give back, see glcloth/visibility/furnace.py Given
uniform vec3 passed;                     // what of the other side's light comes evenly through

void main() {
    int i = item();
    if (i >= vertex_count) return;
    vec4 x = texelFetch(vertex_data, 3 * (first_item + i));
    vec4 N = texelFetch(vertex_data, 3 * (first_item + i) + 1);
    vec3 front = vec3(0.0), back = front;                // irradiance
    vec3 front_given = front, back_given = front;        // what of the light a white fabric gives back
    vec2 upright_sums = vec2(0.0);                       // luminance of `given` times how upright it is
    vec2 given = vec2(1.0 - 2.0 * flat_share, flat_share);
    vec2 lean = 0.5 * vec2(upright_of_height, upright - 0.5 * upright_of_height);
    const vec3 LUMINANCE = vec3(0.2126, 0.7152, 0.0722);
    for (int k = 0; k < gaussian_count; ++k) {
        Gaussian light = fetch_gaussian(k);
        float cos_theta = dot(N.xyz, light.xi);
        int group = (1 + k) >> 2, at = (1 + k) & 3;
        float V = unpackUnorm4x8(texelFetch(mean_data, 2 * i * group_count + group).x)[at];
        float V_back = unpackUnorm4x8(texelFetch(mean_data, (2 * i + 1) * group_count + group).x)[at];
        vec2 sums = V * gaussian_sums(k, cos_theta), sums_back = V_back * gaussian_sums(k, -cos_theta);
        front += light.L * sums.x;
        back += light.L * sums_back.x;
        front_given += light.L * dot(sums, given);
        back_given += light.L * dot(sums_back, given);
        upright_sums += dot(light.L, LUMINANCE) * vec2(dot(sums, lean), dot(sums_back, lean));
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
        vec2 response = response_to(cos_theta, flat_share);
        front_given += sun.E * response.x;
        back_given += sun.E * response.y;
        vec2 z = max(vec2(cos_theta, -cos_theta), 0.0);
        upright_sums += dot(sun.E, LUMINANCE) * (lean.x * z + lean.y * min(100.0 * z, 1.0));
    }
    vec3 share = (own_reflectance ? texelFetch(reflectance_data, i).rgb : reflectance) / PI;
    upright_sums /= max(vec2(dot(front_given, LUMINANCE), dot(back_given, LUMINANCE)), 1e-12);
    front_given = share * max(front_given, vec3(0.0));
    back_given = share * max(back_given, vec3(0.0));
#ifdef SHEER
    vec3 through = passed / PI;
    radiance[2 * (first_item + i)] = vec4(front_given + through * max(back, vec3(0.0)), upright_sums.x);
    radiance[2 * (first_item + i) + 1] = vec4(back_given + through * max(front, vec3(0.0)), upright_sums.y);
#else
    radiance[2 * (first_item + i)] = vec4(front_given, upright_sums.x);
    radiance[2 * (first_item + i) + 1] = vec4(back_given, upright_sums.y);
#endif
}
