// A pixel of objects with textures, gloss and metal: GGX over Lambertians, in the light of "lit.glsl".
#define GLOSSY 1
#include "core/math.glsl"
#include "inputs/picture/output.glsl"
#if defined(PARTS) || defined(CATCHER)
#include "inputs/picture/parts.glsl"
#endif
#include "inputs/picture/pixel_uv.glsl"
#include "lit.glsl"
uniform samplerBuffer look_data;      // of each triangle (color, layer of its picture or -1), (roughness, metalness, -, -)
uniform sampler2DArray base_pictures;  // linear
uniform float look_taps;      // places at which a pixel reads one at most
#include "inputs/picture/solid_output.glsl"

const float DIELECTRIC = 0.04;  // reflectance at normal incidence of what is no metal, as in glTF

vec3 base_color(ivec2 pixel, vec4 look) {
    return look.w < 0.0 ? look.rgb : look.rgb * mean_of_pixel(base_pictures, look.w, pixel_uv(pixel), vec2(1.0), look_taps);
}

void shade(ivec2 pixel) {
    vec3 N = texelFetch(frame_N, pixel, 0).xyz;
    int triangle = triangle_at(pixel);
    vec4 look = texelFetch(look_data, 2 * triangle);
    vec4 finish = texelFetch(look_data, 2 * triangle + 1);
    vec3 base = base_color(pixel, look);
    // Matt through and through, as objects are that say nothing else.
    bool matt = finish.x >= 1.0 && finish.y <= 0.0;
    vec3 F_0 = matt ? vec3(0.0) : mix(vec3(DIELECTRIC), base, finish.y);
    gloss = gloss_from(N, omega_o_at(vec2(pixel) + 0.5), F_0, max(finish.x, LEAST_ROUGHNESS));
    vec3 E = irradiance(pixel, N);
    float cos_o = dot(N, gloss.omega_o);
    vec3 kept = matt ? vec3(1.0) : (vec3(1.0) - F_color(vec3(DIELECTRIC), cos_o)) * (1.0 - finish.y);
    vec3 radiance_per_irradiance = base * kept / PI;
    vec3 L = radiance_per_irradiance * E + (matt ? vec3(0.0) : L_gloss);
    put(pixel, triangle, L, radiance_per_irradiance);
}
