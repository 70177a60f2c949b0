// Points of a sun, which is a disc far away.   Twin: glcloth/twins/sun_disc.py
#include "core/math.glsl"

// [own]  Point n of so many spread evenly over the unit disk, turned by `turn` of a whole turn: Vogel's spiral (1979), so that
// the mean over all turns is that over the disk.
vec2 disc_point(int n, int count, float turn) {
    float phi = 2.0 * PI * (fract(0.3819660112501051 * float(n)) + turn);
    return sqrt((float(n) + 0.5) / float(count)) * vec2(cos(phi), sin(phi));
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
