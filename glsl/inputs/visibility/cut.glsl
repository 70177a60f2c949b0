// A triangle of a smooth surface and its four parts.
#include "trace/smooth.glsl"

struct Smooth {
    vec3 a, b, c;        // corners
    vec3 n_a, n_b, n_c;  // the surface's normals there
};

Smooth part_of(Smooth t, int part) {
    vec3 ab = curved_middle(t.a, t.b, t.n_a, t.n_b), n_ab = middle_normal(t.n_a, t.n_b);
    vec3 bc = curved_middle(t.b, t.c, t.n_b, t.n_c), n_bc = middle_normal(t.n_b, t.n_c);
    vec3 ca = curved_middle(t.c, t.a, t.n_c, t.n_a), n_ca = middle_normal(t.n_c, t.n_a);
    return Smooth(part == 0 ? t.a : part == 2 ? ca : ab, part == 1 ? t.b : part == 0 ? ab : bc,
        part == 2 ? t.c : part == 1 ? bc : ca, part == 0 ? t.n_a : part == 2 ? n_ca : n_ab,
        part == 1 ? t.n_b : part == 0 ? n_ab : n_bc, part == 2 ? t.n_c : part == 1 ? n_bc : n_ca);
}
