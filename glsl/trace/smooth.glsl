// A triangle of a smooth surface cut into four.   Twin: glcloth/twins/smooth.py

// [own]  The middle of an edge, on the cubic that leaves both ends along the surface there (Hermite, as PN triangles of Vlachos
// 2001 have it). The order of the ends does not matter, to the last bit: triangles side by side stay closed.
vec3 curved_middle(vec3 a, vec3 b, vec3 n_a, vec3 n_b) {
    bool turned = a.x > b.x || a.x == b.x && (a.y > b.y || a.y == b.y && a.z > b.z);
    vec3 first = turned ? b : a, last = turned ? a : b;
    vec3 n_first = turned ? n_b : n_a, n_last = turned ? n_a : n_b;
    vec3 d = last - first;
    return 0.5 * (first + last) + 0.125 * (dot(n_last, d) * n_last - dot(n_first, d) * n_first);
}

// [own]  Its normal: the mean of those at the ends.
vec3 middle_normal(vec3 n_a, vec3 n_b) {
    vec3 n = n_a + n_b;
    return dot(n, n) > 1e-12 ? normalize(n) : n_a;
}

// [own]  Barycentric coordinates in the triangle of a point of one of its four parts by those in the part: part 0, 1 or 2 is at
// that corner and keeps it in its place, the others are the middles of the edges; part 3 has those of ab, bc, ca.
vec3 weights_of_whole(vec3 weights, int part) {
    vec3 half_weights = 0.5 * weights;
    return part == 3 ? half_weights.xxy + half_weights.zyz
        : half_weights + vec3(part == 0 ? 0.5 : 0.0, part == 1 ? 0.5 : 0.0, part == 2 ? 0.5 : 0.0);
}

// [own]  The part that a point lies in, and its coordinates there.
int part_at(vec3 weights) { return weights.x > 0.5 ? 0 : weights.y > 0.5 ? 1 : weights.z > 0.5 ? 2 : 3; }

vec3 weights_in_part(vec3 weights, int part) {
    return part == 3 ? 1.0 - 2.0 * weights.zxy
        : 2.0 * weights - vec3(part == 0 ? 1.0 : 0.0, part == 1 ? 1.0 : 0.0, part == 2 ? 1.0 : 0.0);
}
