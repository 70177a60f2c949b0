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

// [own]  What the horizon z = 0 leaves of a disc about `middle`: the direction toward the middle of that part, and its share.
vec4 disc_above(vec3 middle, float sin_radius) {
    float cos_2 = 1.0 - middle.z * middle.z;
    if (abs(middle.z) >= sin_radius || cos_2 < 1e-6) return vec4(middle, middle.z > 0.0 ? 1.0 : 0.0);
    float t = middle.z / sin_radius;
    float chord = sqrt(1.0 - t * t);
    float share = 0.5 + (t * chord + atan(t, chord)) / PI;
    // The height of the centroid over the middle. A sliver weighs nothing, wherever it is.
    float rise = sin_radius * min(2.0 / 3.0 * chord * chord * chord / (PI * max(share, 1e-3)), 1.0);
    vec3 up = vec3(-middle.xy * middle.z, cos_2) / sqrt(cos_2);
    return vec4(normalize(middle + rise * up), share);
}
