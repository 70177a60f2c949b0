// Nodes on the narrow lobe of one tangent.   [own]
// Twin: glcloth/twins/pool.py
#include "core/math.glsl"

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
