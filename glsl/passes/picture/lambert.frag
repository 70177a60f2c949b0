#version 430
// Shades the objects and the ground where they are seen: Lambertians that get the light of "lit.glsl".
#include "core/math.glsl"
#include "inputs/picture/gbuffer.glsl"
#include "inputs/picture/gbuffer_point.glsl"
#include "lit.glsl"
#include "inputs/visibility/reflectance.glsl"
uniform float pass_weight;    // share of this sample in the pixel
uniform float pass_cover;     // this pass's part of the pixel's coverage
out vec4 color;

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec3 N = texelFetch(frame_N, pixel, 0).xyz;
    vec3 L = texelFetch(reflectance_data, triangle_at(pixel)).rgb / PI * irradiance(pixel, N);
    color = vec4(L * pass_weight, pass_cover);
}
