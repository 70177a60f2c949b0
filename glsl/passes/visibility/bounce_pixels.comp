#version 430
// Interpolates the radiance that comes back to the vertices to the covered pixels, for the side that is seen.   [own]
#include "inputs/picture/gbuffer.glsl"
#include "inputs/picture/gbuffer_point.glsl"
layout(local_size_x = 8, local_size_y = 8) in;
uniform samplerBuffer mean_data;  // passes/visibility/bounce_spread.comp
uniform isamplerBuffer corner_index;
layout(rgba16f) writeonly uniform image2DArray bounced_light;  // radiance; luminance x direction, world

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, textureSize(frame_N, 0)))) return;
    if (texelFetch(frame_N, pixel, 0).w == 0.0) return;
    int first = 3 * triangle_at(pixel);
    ivec3 corner = ivec3(texelFetch(corner_index, first).x, texelFetch(corner_index, first + 1).x,
        texelFetch(corner_index, first + 2).x);
    corner = 4 * corner + (texelFetch(frame_x, pixel, 0).w < 0.0 ? 2 : 0);
    vec3 w = weights_at(pixel);
    for (int n = 0; n < 2; ++n) {
        vec4 value = w.x * texelFetch(mean_data, corner.x + n) + w.y * texelFetch(mean_data, corner.y + n)
            + w.z * texelFetch(mean_data, corner.z + n);
        imageStore(bounced_light, ivec3(pixel, n), clamp(value, vec4(-6e4), vec4(6e4)));
    }
}
