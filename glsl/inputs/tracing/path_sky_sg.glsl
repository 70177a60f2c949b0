// The light from far away: spherical Gaussians, each drawn as often as it is bright.
#include "inputs/picture/lights.glsl"
#include "sg/draw.glsl"
uniform samplerBuffer share_data;  // of each Gaussian its share of the draws; the sum of those up to it

// Radiance, and the density of `sky_direction` per solid angle.
vec3 sky_radiance(vec3 from, vec3 omega, out float pdf) {
    vec3 L = vec3(0.0);
    pdf = 0.0;
    int k = 0;
    do {
        Gaussian g = fetch_gaussian(k);
        float value = k < gaussian_count ? exp(g.sharpness * (dot(omega, g.xi) - 1.0)) : 0.0;
        L += value * g.L;
        pdf += texelFetch(share_data, k).x * gaussian_pdf(value, g.sharpness);
    } while (++k < gaussian_count);
    return L;
}

// By a number that chooses, and two that place.
vec3 sky_direction(vec3 from, vec2 choice, vec2 place) {
    int k = 0;
    while (k + 1 < gaussian_count && choice.x >= texelFetch(share_data, k).y) ++k;
    Gaussian g = fetch_gaussian(k);
    return gaussian_direction(g.xi, g.sharpness, place);
}
