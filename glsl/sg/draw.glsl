// Directions drawn from a spherical Gaussian exp(sharpness (omega . xi - 1)), as from a von Mises-Fisher distribution.
// Twin: glcloth/twins/draw.py
#include "core/math.glsl"
#include "core/shading_frame.glsl"

const float WIDE = 0.05;  // below this sharpness directions are drawn evenly

// [own]  A direction by two numbers from 0 to 1, by inverting the distribution of its cosine to the axis.
vec3 gaussian_direction(vec3 xi, float sharpness, vec2 u) {
    // How far the cosine is from 1.
    float below = sharpness > WIDE ? -log(max(mix(exp(-2.0 * sharpness), 1.0, u.x), 1e-38)) / sharpness : 2.0 - 2.0 * u.x;
    float s = sqrt(max(below * (2.0 - below), 0.0));
    float phi = 2.0 * PI * u.y;
    vec3 x = orthogonal_part(vec3(xi.y, xi.z, xi.x), xi);
    return normalize(s * (cos(phi) * x + sin(phi) * cross(xi, x)) + (1.0 - below) * xi);
}

// [own]  The density of such directions where the Gaussian is `value`, per solid angle.
float gaussian_pdf(float value, float sharpness) {
    return sharpness > WIDE ? value * sharpness / (2.0 * PI * (1.0 - exp(-2.0 * sharpness))) : 0.25 / PI;
}
