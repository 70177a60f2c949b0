// The integral over phi_i of a circular Gaussian, by which the table of T_l is scaled.   [Miz 14]
// Twin: glcloth/twins/azimuth.py
#include "core/math.glsl"
#include "core/erf.glsl"

// [own]  The integral over phi in [-pi/2, pi/2] of exp(kappa_prime (cos(phi - phi_k) - 1)) |cos((phi - phi_k) / 2)|:
// with s = sin((phi - phi_k) / 2) the exponent is exactly -2 kappa_prime s^2, so erf gives it. T_l divided by it stays
// between 0 and 3 and bends little, for all phi_k and kappa_prime; T_l itself falls to nothing past 90 degrees.
// kappa_prime = 2 / sigma_k_prime^2 > 0, |phi_k| <= pi.
float azimuth_mass(float phi_k, float kappa_prime) {
    float kappa = max(kappa_prime, 1e-6);
    float r = sqrt(2.0 * kappa);
    float near = erf(r * sin(0.25 * PI - 0.5 * abs(phi_k)));
    float far = erf(r * sin(0.25 * PI + 0.5 * abs(phi_k)));
    // Past 90 degrees the antipode of phi_k is inside, where |cos| folds.
    float mass = abs(phi_k) <= 0.5 * PI ? near + far : near + 2.0 * erf(r) - far;
    return sqrt(0.5 * PI / kappa) * max(mass, 0.0);
}
