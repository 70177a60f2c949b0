#version 430
// A ray toward each sun from every covered pixel.   [own]
#include "inputs/picture/gbuffer.glsl"
#include "inputs/picture/gbuffer_point.glsl"
// Defines: SHEER, where cloth lets light through.
#include "sight.glsl"
layout(local_size_x = 8, local_size_y = 8) in;
uniform samplerBuffer sun_data;  // toward each sun
layout(rgba8) writeonly uniform image2DArray seen;
uniform int sun_count;           // at least 1
uniform int first_layer;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, textureSize(frame_N, 0)))) return;
    vec4 N = texelFetch(frame_N, pixel, 0);
    if (N.w == 0.0) return;
    vec3 x = origin_at(pixel);
    vec4 four = vec4(0.0);
    int s = 0;
    do {
        vec3 omega = texelFetch(sun_data, s).xyz;
        float V = 0.0;
        // Below the horizon there is no light to hide.
        if (dot(omega, N.xyz) > 0.0) {
#ifdef SHEER
            Visit first;
            V = seen_along(x, omega, first);
#else
            Visit visit = Visit(3e38, NO_TRIANGLE, vec2(0.0));
            Ray ray = make_ray(x, omega, 0.0, 3e38);
            traverse(ray, visit);
            V = visit.t > 0.0 ? 1.0 : 0.0;
#endif
        }
        if ((s & 3) == 0) four = vec4(0.0);
        four += V * vec4(equal(ivec4(s & 3), ivec4(0, 1, 2, 3)));
        // Store whole texels, and the last one as it is.
        if ((s & 3) == 3 || s + 1 == sun_count) imageStore(seen, ivec3(pixel, first_layer + (s >> 2)), four);
    } while (++s < sun_count);
}
