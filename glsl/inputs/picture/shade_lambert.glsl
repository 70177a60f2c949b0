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
#include "inputs/picture/solid_output.glsl"

void shade(ivec2 pixel) {
    vec3 N = texelFetch(frame_N, pixel, 0).xyz;
    vec3 radiance_per_irradiance = texelFetch(reflectance_data, triangle_at(pixel)).rgb / PI;
    vec3 L = radiance_per_irradiance * irradiance(pixel, N);
    put(pixel, triangle_at(pixel), L, radiance_per_irradiance);
}
