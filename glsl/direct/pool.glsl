// Nodes on the narrow lobe of one tangent.   [own]
// Twin: glcloth/twins/pool.py
#include "core/math.glsl"
#include "direct/slots.glsl"

// [own]  The place in 0..1, in a table by mu = -theta_o, of the lobe about theta_i = mu; low and high are the ends of
// theta above both horizons, and columns are dense there, over `width` radians.
float column_of_lobe(float mu, float low, float high, float width) {
    vec3 at = vec3(mu, -0.5 * PI, 0.5 * PI);
    vec3 place = at / PI + 0.5 * (atan((at - low) / width) + atan((at - high) / width));
    return (place.x - place.y) / (place.z - place.y);
}

// [own]  sin(phi_max) of a tangent tilted by a at inclination theta: its cylinder is above both horizons for
// cos(phi) > tan(a) tan(theta) (all of |phi| < pi / 2 where that is negative).
float sin_limit(float sin_theta, float cos_theta, float cos_tilt, float sin_tilt) {
    float q = clamp(sin_tilt * sin_theta / max(cos_tilt * cos_theta, 1e-6), 0.0, 1.0);
    return sqrt(max(1.0 - q * q, 0.0));
}

// [Miz 5-6, 12]  Inputs of the terms from a pair of nodes (theta, phi) and (theta, -phi) on a tangent's lobe: columns
// M, F_r, cos(phi_d / 2); phi_o as its cosine and sine.
mat3x2 scatter_pair(float cos_phi, float sin_phi, vec2 phi_o, float cos_theta_d, float F_0, vec4 series) {
    vec4 cos_phi_d = vec4(cos_phi * phi_o.x + sin_phi * phi_o.y, cos_phi * phi_o.x - sin_phi * phi_o.y, 0.0, 0.0);
    vec4 M = D_masks(g_of_cos(cos_phi_d, series), vec4(cos_phi), vec4(max(phi_o.x, 0.0)));
    vec4 cos_half_phi_d = sqrt(max(0.5 + 0.5 * cos_phi_d, 0.0));
    return mat3x2(M.xy, F_slots(vec4(F_0), vec4(cos_theta_d), cos_half_phi_d).xy, cos_half_phi_d.xy);
}
