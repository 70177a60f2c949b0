#version 430
// The light that is left of each sun on the side of the cloth that the pixels do not see.   [own]
#include "inputs/picture/gbuffer.glsl"
#include "inputs/visibility/origin_behind.glsl"
#include "inputs/visibility/sheets.glsl"
layout(local_size_x = 8, local_size_y = 8) in;
uniform samplerBuffer sun_data;  // toward each sun
layout(rgba8) writeonly uniform image2DArray seen_behind;
uniform int sun_count;           // at least 1

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, textureSize(frame_N, 0)))) return;
    vec4 N = texelFetch(frame_N, pixel, 0);
    if (N.w == 0.0) return;
    vec3 x = origin_behind(pixel);
    int s = 0;
    do {
        vec3 omega = texelFetch(sun_data, s).xyz, T = vec3(0.0);
        Visit first;
        if (dot(omega, N.xyz) < 0.0) T = left_along(x, omega, first);
        imageStore(seen_behind, ivec3(pixel, s), vec4(T, 0.0));
    } while (++s < sun_count);
}
