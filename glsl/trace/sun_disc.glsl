// Points of a sun, which is a disc far away.   Twin: glcloth/twins/sun_disc.py
#include "core/math.glsl"

// [own]  Point n of an even sequence over the unit disk: R2 (Roberts 2018, "The unreasonable effectiveness of quasirandom
// sequences"), its first number the area up to the point's radius; all turned by `turn` of a whole turn.
vec2 disc_point(int n, float turn) {
    vec2 u = fract(0.5 + vec2(0.7548776662466927, 0.5698402909980532) * float(n));
    float phi = 2.0 * PI * (u.y + turn);
    return sqrt(u.x) * vec2(cos(phi), sin(phi));
}

// [own]  The direction toward a point of a disc of angular radius atan(tan_radius) about `middle`.
vec3 disc_direction(vec3 middle, float tan_radius, vec2 at) {
    // The axis that the middle is least along is sure to have a part across it.
    vec3 size = abs(middle);
    vec3 axis = size.x <= min(size.y, size.z) ? vec3(1.0, 0.0, 0.0)
        : size.y <= size.z ? vec3(0.0, 1.0, 0.0) : vec3(0.0, 0.0, 1.0);
    vec3 x = normalize(cross(axis, middle));
    return normalize(middle + tan_radius * (at.x * x + at.y * cross(middle, x)));
}
