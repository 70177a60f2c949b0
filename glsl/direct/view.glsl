// Directions omega_o as points of a disk that is finer toward its rim, the horizon, or toward its middle.   [own]
// Twin: glcloth/twins/view.py

// [own]  The point of a direction above the horizon, where texels are `rim` times as many a radian; 1: stereographic.
vec2 to_view(vec3 omega, float rim) {
    return omega.xy / (1.0 + rim * omega.z);
}

// [own]  The direction of a point; points beyond the unit circle are those of the horizon.
vec3 from_view(vec2 p, float rim) {
    p /= max(length(p), 1.0);
    float square = dot(p, p);
    float z = (sqrt(1.0 + square * (rim * rim - 1.0)) - rim * square) / (1.0 + rim * rim * square);
    return vec3(p * (1.0 + rim * z), z);
}
