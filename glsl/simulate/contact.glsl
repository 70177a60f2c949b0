// Contact of the cloth with itself, and the hash of its cells.  Twin: glcloth/twins/contact.py
#include "simulate/collide.glsl"

// [own] Bucket of a cell (whole numbers as float, |cell| < 2^23) in a table of `size` (a power of two) buckets: the
// primes of Teschner, Heidelberger, Mueller, Pomeranets, Gross 2003, "Optimized spatial hashing", in wrapping integers.
int bucket(vec3 cell, int size) {
    return ((int(cell.x) * 73856093) ^ (int(cell.y) * 19349663) ^ (int(cell.z) * 83492791)) & (size - 1);
}

// [own] The motion of one particle at p_0 away from another at p_1 nearer than `gap`: its share w_0 / (w_0 + w_1) of the
// push that parts them, less friction against the difference `slide` of their motions in this substep (p_0's less p_1's).
// Zero beyond the gap, and when the two coincide (no direction) or neither can move.
vec3 part(vec3 p_0, vec3 p_1, float w_0, float w_1, float gap, vec3 slide, float mu) {
    vec3 e = p_0 - p_1;
    float l = length(e);
    float w = w_0 + w_1;
    if (l >= gap || l <= 0.0 || w <= 0.0) {
        return vec3(0.0);
    }
    vec3 n = e / l;
    return (w_0 / w) * ((gap - l) * n + friction(slide - dot(slide, n) * n, gap - l, mu));
}
