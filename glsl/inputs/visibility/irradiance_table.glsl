// Irradiance of Gaussians of amplitude 1 by the cosine of their axis: a table that the host makes for the lights of a draw.
// Twin of its values: glcloth/twins/lambert.py
uniform samplerBuffer irradiance_table;

const int IRRADIANCE_STEPS = 256;  // of the cosine, from -1 to 1

// By the clamped cosine, and from all directions on that side alike.
vec2 gaussian_sums(int k, float cos_theta) {
    float x = float(IRRADIANCE_STEPS) * (0.5 + 0.5 * clamp(cos_theta, -1.0, 1.0));
    int i = min(int(x), IRRADIANCE_STEPS - 1);
    int at = k * (IRRADIANCE_STEPS + 1) + i;
    return mix(texelFetch(irradiance_table, at).xy, texelFetch(irradiance_table, at + 1).xy, x - float(i));
}

float gaussian_irradiance(int k, float cos_theta) { return gaussian_sums(k, cos_theta).x; }
