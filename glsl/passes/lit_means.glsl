// Irradiance from Gaussians and suns, each as far as the pixel sees it: "lit.glsl" of methods direct and paper.
#include "passes/lights.glsl"
layout(binding = 2) uniform sampler2DArray seen;               // four values a texel: V_0, V_1 .. V_K, then the suns'
layout(binding = 9) uniform samplerBuffer irradiance_table;    // of each Gaussian of amplitude 1, over the cosine
uniform bool everything;  // nothing is hidden
uniform int sun_number;   // of the first sun's value

const int STEPS = 256;    // of the table, from -1 to 1

float V_number(ivec2 pixel, int n) {
    return everything ? 1.0 : texelFetch(seen, ivec3(pixel, n >> 2), 0)[n & 3];
}

vec3 irradiance(ivec2 pixel, vec3 N) {
    vec3 E = vec3(0.0);
    for (int k = 0; k < gaussian_count; ++k) {
        Gaussian light = fetch_gaussian(k);
        float x = float(STEPS) * (0.5 + 0.5 * clamp(dot(N, light.xi), -1.0, 1.0));
        int i = min(int(x), STEPS - 1);
        int at = k * (STEPS + 1) + i;
        float one = mix(texelFetch(irradiance_table, at).x, texelFetch(irradiance_table, at + 1).x, x - float(i));
        E += light.L * (V_number(pixel, 1 + k) * one);
    }
    for (int s = 0; s < sun_count; ++s) {
        Sun sun = fetch_sun(s);
        E += sun.E * (V_number(pixel, sun_number + s) * max(dot(N, sun.omega), 0.0));
    }
    return max(E, vec3(0.0));
}
