// Directions of the upper hemisphere as points of the unit disk, by stereographic projection from the nadir.
// Twin: glcloth/twins/disk.py

// [own]  The point of a direction above the horizon, which is the unit circle.
vec2 to_disk(vec3 omega) {
    return omega.xy / (1.0 + omega.z);
}

// [own]  The direction of a point; points beyond the unit circle are those of the horizon.
vec3 from_disk(vec2 p) {
    p /= max(length(p), 1.0);
    float square = dot(p, p);
    return vec3(2.0 * p, 1.0 - square) / (1.0 + square);
}
