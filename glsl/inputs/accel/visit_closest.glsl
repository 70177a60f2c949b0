// A traversal looks for the nearest hit. Of hits at the same t the triangle of the lowest number counts, so that
// every structure finds the same one.
#include "trace/shared.glsl"

struct Visit {
    float t;
    uint triangle;
    vec2 weights;  // barycentric coordinates of the second and third corner
};

float t_limit(Visit visit) { return visit.t; }

void accept(inout Visit visit, Ray ray, uint tag, vec4 hit, vec2 window) {
    uint triangle = tag & ~SOLID;
    if (hit.x > ray.t_min && (hit.x < visit.t || hit.x == visit.t && triangle < visit.triangle)) {
        visit = Visit(hit.x, triangle, hit.yz);
    }
}
