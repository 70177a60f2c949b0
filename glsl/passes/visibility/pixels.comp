#version 430
// Interpolates the vertices' visibility to the covered pixels, for the side that is seen.   [own]
#include "inputs/picture/gbuffer.glsl"
#include "inputs/picture/gbuffer_point.glsl"
layout(local_size_x = 8, local_size_y = 8) in;
uniform usamplerBuffer mean_data;  // of a vertex front and back, of a side the groups of four
uniform isamplerBuffer corner_index;
layout(rgba8) writeonly uniform image2DArray seen;  // as inputs/visibility/seen_layers.glsl reads it
uniform int group_count;
uniform bool everything;           // nothing is hidden but from the suns

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, textureSize(frame_N, 0)))) return;
    if (texelFetch(frame_N, pixel, 0).w == 0.0) return;
    int group = 0;
    if (everything) {
        do imageStore(seen, ivec3(pixel, group), vec4(1.0)); while (++group < group_count);
        return;
    }
    int first = 3 * triangle_at(pixel);
    ivec3 corner = ivec3(texelFetch(corner_index, first).x, texelFetch(corner_index, first + 1).x,
        texelFetch(corner_index, first + 2).x);
    corner = (2 * corner + (texelFetch(frame_x, pixel, 0).w < 0.0 ? 1 : 0)) * group_count;
    vec3 weights = weights_at(pixel);
    do {
        vec4 V = weights.x * unpackUnorm4x8(texelFetch(mean_data, corner.x + group).x)
            + weights.y * unpackUnorm4x8(texelFetch(mean_data, corner.y + group).x)
            + weights.z * unpackUnorm4x8(texelFetch(mean_data, corner.z + group).x);
        imageStore(seen, ivec3(pixel, group), V);
    } while (++group < group_count);
}
