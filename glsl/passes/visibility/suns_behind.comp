#version 430
// The light that is left of each sun on the side of the cloth that the pixels do not see.   [own]
// Defines: FIRST, as passes/visibility/suns.comp.
#include "inputs/picture/gbuffer.glsl"
#include "inputs/visibility/origin_behind.glsl"
#include "inputs/visibility/origin_finer.glsl"
#include "inputs/visibility/sheets.glsl"
#include "inputs/visibility/sun_points.glsl"
layout(local_size_x = 8, local_size_y = 8) in;
#ifdef FIRST
layout(rgba8) writeonly uniform image2DArray first_image;
#else
#include "inputs/visibility/agreed.glsl"
layout(rgba8) writeonly uniform image2DArray seen_behind;
#endif

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, textureSize(frame_N, 0)))) return;
    vec4 N = texelFetch(frame_N, pixel, 0);
    if (N.w == 0.0) return;
    vec3 x = origin_behind(pixel);
    if (own_levels > 0) x = origin_finer(pixel, -texelFetch(frame_x, pixel, 0).w);
    Visit first;
#ifdef FIRST
    int s = 0;
    do {
        vec4 sun = texelFetch(sun_data, s);
        vec3 T = vec3(0.0);
        if (dot(sun.xyz, N.xyz) < 0.0) T = left_along(x, first_point(pixel, sun), first);
        imageStore(first_image, ivec3(pixel, s), vec4(T, 0.0));
    } while (++s < sun_count);
#else
    vec4 sun = texelFetch(sun_data, sun_number);
    vec4 own = texelFetch(first_seen, ivec3(pixel, sun_number), 0);
    if (dot(sun.xyz, N.xyz) < 0.0 && sun.w > 0.0 && any(greaterThanEqual(apart(pixel, sun_number, own), vec4(AGREE)))) {
        own = vec4(0.0);
        int n = 0;
        do own.rgb += left_along(x, point_of(pixel, sun, n), first); while (++n < points_of(sun));
        own.rgb /= float(points_of(sun));
    }
    imageStore(seen_behind, ivec3(pixel, sun_number), own);
#endif
}
