// A pixel of the objects and the ground: Lambertians that get the light of "lit.glsl".
#include "core/math.glsl"
#include "inputs/picture/output.glsl"
#if defined(PARTS) || defined(CATCHER)
#include "inputs/picture/parts.glsl"
#endif
#include "inputs/picture/gbuffer.glsl"
#include "inputs/picture/gbuffer_point.glsl"
#include "lit.glsl"
#include "inputs/visibility/reflectance.glsl"
uniform float pass_weight;    // share of this sample in the pixel
uniform float pass_cover;     // what this pass adds to the pixel's coverage: the first all
#ifdef CATCHER
#include "inputs/picture/catcher.glsl"
#endif

void shade(ivec2 pixel) {
    vec3 N = texelFetch(frame_N, pixel, 0).xyz;
    vec3 radiance_per_irradiance = texelFetch(reflectance_data, triangle_at(pixel)).rgb / PI;
    vec3 L = radiance_per_irradiance * irradiance(pixel, N);
    color = vec4(L * pass_weight, pass_cover);
#ifdef CATCHER
    if (triangle_at(pixel) >= first_catching) {
        color = caught(pixel, pass_weight);
#ifdef PARTS
        bounce_color = through_color = vec4(0.0);
#endif
        return;
    }
#endif
#ifdef PARTS
    bounce_color = vec4(radiance_per_irradiance * L_bounce * pass_weight, 0.0);
    through_color = vec4(0.0);
#endif
}
