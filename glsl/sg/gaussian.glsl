// Circular Gaussians, given by their sharpness 2 / sigma^2.   [Miz 2, 17]
// Twin: glcloth/twins/gaussian.py

// [Miz 17, erratum E1]  g_c(x; mu_1, sigma_1) g_c(x; mu_2, sigma_2) = alpha g_c(x; mu_3, sigma_3)
// Returns (mu_3, sharpness_3, alpha). With d = mu_2 - mu_1 neither the angle nor the exponent subtracts large numbers.
vec3 g_c_product(float mu_1, float sharpness_1, float mu_2, float sharpness_2) {
    float d = clamp(mu_2 - mu_1, -3.1415925, 3.1415925);  // past pi, atan would turn to the other side
    float m = sharpness_1 + sharpness_2 * cos(d);
    float n = sharpness_2 * sin(d);
    float sharpness_3 = sqrt(m * m + n * n);
    float half_sine = sin(0.5 * d);
    float sum = sharpness_1 + sharpness_2 + sharpness_3;
    float lost = 4.0 * sharpness_1 * sharpness_2 * half_sine * half_sine / max(sum, 1e-20);
    return vec3(mu_1 + atan(n, m), sharpness_3, exp(-lost));
}
