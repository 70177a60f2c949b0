// Integrals of a piecewise linear function times Gaussians, in closed form.   [Miz below 16]
// Three Gaussians at once, because the surface, volume and isotropic terms share their nodes.
// Twin: glcloth/twins/segments.py
#include "core/math.glsl"
#include "core/erf.glsl"

// [own]  exp(-u^2) integrated twice: sqrt(pi) / 2 u erf(u) + gaussian / 2, given gaussian = exp(-u^2).
vec3 twice_integrated(vec3 u, vec3 gaussian) {
    const float half_root_pi = 0.5 * sqrt(PI);
    return half_root_pi * u * vec3(erf(u.x), erf(u.y), erf(u.z)) + 0.5 * gaussian;
}

// [Miz below 16]  The weight of h at a node theta_s, where h = a_s theta + b_s between nodes of equal distance: the
// integral of g times the hat over the node, over sigma. The printed sum of a_s and b_s terms is the second difference
// of twice_integrated, given here at the node before, at the node and at the node after it.
// u = (theta_s - mu) / sigma, gaussian = exp(-u^2), step = distance of the nodes / sigma. A small step cancels; there a
// series holds to 1e-4.
vec3 hat_integral(vec3 before, vec3 here, vec3 after, vec3 u, vec3 gaussian, vec3 step) {
    vec3 difference = (before - 2.0 * here + after) / step;
    vec3 series = step * gaussian * (1.0 + step * step * (4.0 * u * u - 2.0) / 12.0);
    return mix(difference, series, lessThan(step, vec3(0.2)));
}
