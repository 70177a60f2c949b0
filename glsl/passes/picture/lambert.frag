#version 430
// Shades the objects and the ground where they are seen: Lambertians that get the light of "lit.glsl".
#include "core/math.glsl"
#if defined(PARTS) || defined(CATCHER)
#include "inputs/picture/parts.glsl"
#endif
#include "inputs/picture/gbuffer.glsl"
#include "inputs/picture/gbuffer_point.glsl"
#include "lit.glsl"
#include "inputs/visibility/reflectance.glsl"
uniform float pass_weight;    // share of this sample in the pixel
uniform float pass_cover;     // this pass's part of the pixel's coverage
#ifdef CATCHER
uniform int first_catching;     // from this triangle on only the shadow is shown,
uniform vec2 catcher_middle;    // x and z,
uniform vec2 catcher_fade;      // and from this distance on less of it, to that one
uniform float open_luminance;   // of the irradiance where nothing hides light
#endif
layout(location = 0) out vec4 color;

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec3 N = texelFetch(frame_N, pixel, 0).xyz;
    vec3 radiance_per_irradiance = texelFetch(reflectance_data, triangle_at(pixel)).rgb / PI;
    vec3 L = radiance_per_irradiance * irradiance(pixel, N);
    color = vec4(L * pass_weight, pass_cover);
#ifdef CATCHER
    if (triangle_at(pixel) >= first_catching) {
        float shown = 1.0 - smoothstep(catcher_fade.x, catcher_fade.y, length(origin_at(pixel).xz - catcher_middle));
        float hidden = dot(E_hidden, vec3(0.2126, 0.7152, 0.0722)) / open_luminance;
        color = vec4(vec3(0.0), clamp(hidden, 0.0, 1.0) * shown * pass_weight);
#ifdef PARTS
        bounce_color = through_color = vec4(0.0);
#endif
        return;
    }
#endif
#ifdef PARTS
    bounce_color = vec4(radiance_per_irradiance * L_bounce * pass_weight, 0.0);
    through_color = vec4(radiance_per_irradiance * L_through * pass_weight, 0.0);
#endif
}
