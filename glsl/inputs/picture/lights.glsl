// The lights of a draw, in world space: spherical Gaussians and suns.   [Miz 7]
// glcloth/gpu/scene_buffers.py fills the buffer: the Gaussians, then from texel 2 * MAX_LOBES on the Suns.
#include "core/shared.glsl"

uniform samplerBuffer light_data;
uniform int gaussian_count;
uniform int sun_count;

Gaussian fetch_gaussian(int k) {
    vec4 p = texelFetch(light_data, 2 * k);
    vec4 q = texelFetch(light_data, 2 * k + 1);
    return Gaussian(p.xyz, p.w, q.xyz, 0.0);
}

Sun fetch_sun(int s) {
    vec4 p = texelFetch(light_data, 2 * MAX_LOBES + 2 * s);
    vec4 q = texelFetch(light_data, 2 * MAX_LOBES + 2 * s + 1);
    return Sun(p.xyz, p.w, q.xyz, 0.0);
}
