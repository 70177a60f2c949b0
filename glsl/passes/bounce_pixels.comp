#version 430
// Interpolates the radiance that comes back to the vertices to the covered pixels, for the side that is seen.   [own]
#include "passes/gbuffer.glsl"
#include "passes/gbuffer_point.glsl"
layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 9) uniform samplerBuffer mean_data;      // passes/bounce_spread.comp
layout(binding = 10) uniform isamplerBuffer corner_index;
layout(rgba16f, binding = 0) writeonly uniform image2D bounced_light;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, textureSize(frame_N, 0)))) return;
    if (texelFetch(frame_N, pixel, 0).w == 0.0) return;
    int first = 3 * triangle_at(pixel);
    ivec3 corner = ivec3(texelFetch(corner_index, first).x, texelFetch(corner_index, first + 1).x,
        texelFetch(corner_index, first + 2).x);
    corner = 2 * corner + (texelFetch(frame_x, pixel, 0).w < 0.0 ? 1 : 0);
    vec3 w = weights_at(pixel);
    vec3 L = w.x * texelFetch(mean_data, corner.x).rgb + w.y * texelFetch(mean_data, corner.y).rgb
        + w.z * texelFetch(mean_data, corner.z).rgb;
    imageStore(bounced_light, pixel, vec4(min(L, vec3(6e4)), 1.0));
}
