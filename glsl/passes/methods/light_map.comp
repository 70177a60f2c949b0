#version 430
// The radiance of a few broad Gaussians over the sphere, in world space, for method `direct`.   [Miz 7]
#include "trace/octahedron.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
uniform samplerBuffer gaussian_data;  // pairs: (xi, sharpness), (radiance of the axis, -)
layout(rgba32f) writeonly uniform image2D light_map;
uniform int gaussian_count;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    ivec2 size = imageSize(light_map);
    if (any(greaterThanEqual(pixel, size))) return;
    vec3 omega = from_octahedral(2.0 * vec2(pixel) / vec2(size - 1) - 1.0);
    vec3 L = vec3(0.0);
    for (int k = 0; k < gaussian_count; ++k) {
        vec4 head = texelFetch(gaussian_data, 2 * k);
        L += texelFetch(gaussian_data, 2 * k + 1).rgb * exp(head.w * (dot(omega, head.xyz) - 1.0));
    }
    imageStore(light_map, pixel, vec4(L, 1.0));
}
