// Where rays toward suns start from cloth whose triangles are cut for them (passes/visibility/finer.comp): as
// passes/picture/surface.frag finds it for the triangles as they are, but on their parts.
#include "core/origin.glsl"
#include "inputs/picture/gbuffer_point.glsl"
#include "inputs/visibility/cut.glsl"
#include "inputs/visibility/drawn.glsl"
uniform int own_levels;    // how often the triangles of this surface are cut for suns; 0: origins are as for other rays
uniform int drawn_levels;  // how often they are cut, without a curve, where it is drawn
const float OFFSET_FINER = 0.02;  // of a part's size

vec3 drawn_position(int v) { return texelFetch(drawn_vertices, 3 * v).xyz; }

vec3 drawn_normal(int v) { return texelFetch(drawn_vertices, 3 * v + 1).xyz; }

// `side`: 1 of the front, -1 of the back.
vec3 origin_finer(ivec2 pixel, float side) {
    int t = triangle_at(pixel);
    vec3 w = weights_at(pixel);
    for (int level = 0; level < drawn_levels; ++level) {
        w = weights_of_whole(w, t & 3);
        t >>= 2;
    }
    // The triangle before it was cut has its corners in its outermost parts.
    int first = t << (2 * drawn_levels), outermost = ((1 << (2 * drawn_levels)) - 1) / 3;
    int a = texelFetch(drawn_corners, 3 * first).x, b = texelFetch(drawn_corners, 3 * (first + outermost) + 1).x;
    int c = texelFetch(drawn_corners, 3 * (first + 2 * outermost) + 2).x;
    Smooth s = Smooth(drawn_position(a), drawn_position(b), drawn_position(c), drawn_normal(a), drawn_normal(b), drawn_normal(c));
    int level = 0;
    do {
        int part = part_at(w);
        w = weights_in_part(w, part);
        s = part_of(s, part);
    } while (++level < own_levels);
    vec3 x = w.x * s.a + w.y * s.b + w.z * s.c;
    vec3 across = side * cross(s.b - s.a, s.c - s.a);
    float area_2 = length(across);
    vec3 step_off = area_2 > 0.0 ? OFFSET_FINER * inversesqrt(area_2) * across : vec3(0.0);
    return lifted(x, w, s.a, s.b, s.c, side * s.n_a, side * s.n_b, side * s.n_c) + step_off;
}
