#version 430
// How much of each sun every covered pixel sees.   [own]
// Defines: FIRST, a ray from each pixel, to a point of its own; without it those pixels that do not agree with the ones about
// them send more. SHEER, where cloth lets light through.
#include "inputs/picture/gbuffer.glsl"
#include "inputs/picture/gbuffer_point.glsl"
#include "inputs/visibility/origin_finer.glsl"
#include "sight.glsl"
#include "inputs/visibility/sun_points.glsl"
layout(local_size_x = 8, local_size_y = 8) in;
uniform int first_layer;
#ifdef FIRST
layout(rgba8) writeonly uniform image2DArray first_image;
#else
#include "inputs/visibility/agreed.glsl"
layout(rgba8) uniform image2DArray seen;  // four suns a texel, written one after the other
#endif

float seen_of(vec3 x, vec3 omega) {
#ifdef SHEER
    Visit first;
    return seen_along(x, omega, first);
#else
    Visit visit = Visit(3e38, NO_TRIANGLE, vec2(0.0));
    Ray ray = make_ray(x, omega, 0.0, 3e38);
    traverse(ray, visit);
    return visit.t > 0.0 ? 1.0 : 0.0;
#endif
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, textureSize(frame_N, 0)))) return;
    vec4 N = texelFetch(frame_N, pixel, 0);
    if (N.w == 0.0) return;
    vec3 x = origin_at(pixel);
    if (own_levels > 0) x = origin_finer(pixel, texelFetch(frame_x, pixel, 0).w);
    // Below the horizon there is no light to hide; of a disc that it cuts the part above counts.
#ifdef FIRST
    vec4 four = vec4(0.0);
    int s = 0;
    do {
        vec4 sun = texelFetch(sun_data, s);
        float V = 0.0;
        if (dot(sun.xyz, N.xyz) > -sun.w) V = seen_of(x, first_point(pixel, sun));
        if ((s & 3) == 0) four = vec4(0.0);
        four += V * vec4(equal(ivec4(s & 3), ivec4(0, 1, 2, 3)));
        // Store whole texels, and the last one as it is.
        if ((s & 3) == 3 || s + 1 == sun_count) imageStore(first_image, ivec3(pixel, s >> 2), four);
    } while (++s < sun_count);
#else
    vec4 sun = texelFetch(sun_data, sun_number);
    vec4 own = texelFetch(first_seen, ivec3(pixel, sun_number >> 2), 0);
    float V = own[sun_number & 3];
    float height = dot(sun.xyz, N.xyz);
    bool disagreed = height < sun.w || apart(pixel, sun_number >> 2, own)[sun_number & 3] >= AGREE;
    if (height > -sun.w && sun.w > 0.0 && disagreed) {
        V = 0.0;
        float above = 0.0;
        int n = 0;
        do {
            vec3 point = point_of(pixel, sun, n);
            float counts = dot(point, N.xyz) > 0.0 ? 1.0 : 0.0;
            V += counts * seen_of(x, point);
            above += counts;
        } while (++n < points_of(sun));
        V /= max(above, 1.0);
    }
    ivec3 at = ivec3(pixel, first_layer + (sun_number >> 2));
    vec4 four = (sun_number & 3) == 0 ? vec4(0.0) : imageLoad(seen, at);
    imageStore(seen, at, four + V * vec4(equal(ivec4(sun_number & 3), ivec4(0, 1, 2, 3))));
#endif
}
