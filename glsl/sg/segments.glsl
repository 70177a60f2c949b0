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

// [own]  As twice_integrated of a Gaussian that ends at `end`: behind it a straight line. u = min(u, end) already,
// gaussian = exp(-u^2), over = how far behind the end, slope = sqrt(pi) / 2 erf(end).
vec3 cut_integrated(vec3 u, vec3 gaussian, vec3 over, vec3 slope) {
    return twice_integrated(u, gaussian) + slope * over;
}

// [own]  As hat_integral of a Gaussian that ends `left` node distances behind the node (before it where negative): the nodes'
// values are those of cut_integrated, and u is where the Gaussian is last seen, at the node or at its end.
vec3 cut_hat_integral(vec3 before, vec3 here, vec3 after, vec3 u, vec3 gaussian, vec3 step, float left) {
    // Moments of the part of the hat that is left, before the node and behind it.
    float y = clamp(1.0 + left, 0.0, 1.0), z = clamp(left, 0.0, 1.0);
    float y2 = y * y, z2 = z * z;
    vec3 m = vec3(0.5 * y2 + z - 0.5 * z2, 0.5 * z2 - (y2 * y + 2.0 * z2 * z) / 6.0, y2 * y2 / 12.0 + z2 * z * (1.0 / 3.0 - 0.25 * z));
    vec3 series = step * gaussian * (m.x + step * (-2.0 * m.y * u + step * (2.0 * u * u - 1.0) * m.z));
    return mix(hat_integral(before, here, after, u, gaussian, step), series, lessThan(max(5.0 * step, left), vec3(1.0)));
}
