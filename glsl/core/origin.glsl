// Where rays from a smooth-shaded triangle start.   Twin: glcloth/twins/origin.py

// [own]  Barycentric coordinates of a point x in the plane of a triangle, kept within it; 1, 0, 0 where it has no area.
vec3 barycentric(vec3 x, vec3 a, vec3 b, vec3 c) {
    vec3 n = cross(b - a, c - a);
    float n2 = dot(n, n);
    if (n2 <= 0.0) return vec3(1.0, 0.0, 0.0);
    float v = clamp(dot(cross(x - a, c - a), n) / n2, 0.0, 1.0);
    float w = clamp(dot(cross(b - a, x - a), n) / n2, 0.0, 1.0 - v);
    return vec3(1.0 - v - w, v, w);
}

// [Hanika 2021]  The point of a triangle lifted to the curved surface that its corners' normals describe: no ray above
// the smooth horizon then meets a neighbouring triangle that the curved surface would not have there.
vec3 lifted(vec3 x, vec3 weights, vec3 a, vec3 b, vec3 c, vec3 n_a, vec3 n_b, vec3 n_c) {
    return x - weights.x * min(dot(x - a, n_a), 0.0) * n_a - weights.y * min(dot(x - b, n_b), 0.0) * n_b
        - weights.z * min(dot(x - c, n_c), 0.0) * n_c;
}
