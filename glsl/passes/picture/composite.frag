#version 430
// Adds a layer behind cloth as far as its light is left, and where there is none the environment, or nothing.
#include "core/equirect.glsl"
#ifdef PARTS
#include "inputs/picture/parts.glsl"
#endif
uniform sampler2D left;
uniform sampler2D layer;        // its picture; alpha 0 where there is nothing
uniform sampler2D environment_map;
uniform bool has_environment;
uniform bool catches;           // there is a surface that shows its shadow alone
uniform float beyond_weight;    // share of this sample in the pixel, once
uniform mat3 ray_from_pixel;
uniform mat3 environment_from_world;
layout(location = 0) out vec4 color;

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec3 T = texelFetch(left, pixel, 0).rgb;
    if (T == vec3(0.0)) discard;
    vec4 L = texelFetch(layer, pixel, 0);
    // How much of the pixel nothing covers; of a surface that shows its shadow alone a part.
    float open = catches ? beyond_weight - L.a : L.a > 0.0 ? 0.0 : beyond_weight;
    color = vec4(T * L.rgb, has_environment ? 0.0 : -open * (T.r + T.g + T.b) / 3.0);
    if (has_environment && open != 0.0) {
        vec3 omega = normalize(environment_from_world * (ray_from_pixel * vec3(gl_FragCoord.xy, 1.0)));
        color.rgb += T * textureLod(environment_map, uv_from_direction(omega), 0.0).rgb * open;
    }
#ifdef PARTS
    bounce_color = vec4(0.0);
    through_color = vec4(color.rgb, 0.0);
#endif
}
