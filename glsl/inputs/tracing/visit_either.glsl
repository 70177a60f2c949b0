// A traversal looks for the nearest hit, as inputs/accel/visit_closest.glsl; or, where `triangle` is ANY_HIT, for any.
#include "trace/shared.glsl"

const uint ANY_HIT = 0xfffffffeu;

struct Visit {
    float t;          // of any hit 0
    uint triangle;
    vec2 weights;     // barycentric coordinates of the second and third corner
};

float t_limit(Visit visit) { return visit.t; }

void accept(inout Visit visit, Ray ray, uint tag, vec4 hit, vec2 window) {
    uint triangle = tag & ~SOLID;
    bool any_hit = visit.triangle == ANY_HIT;
    if (hit.x > ray.t_min && (hit.x < visit.t || !any_hit && hit.x == visit.t && triangle < visit.triangle)) {
        visit = Visit(any_hit ? 0.0 : hit.x, any_hit ? ANY_HIT : triangle, hit.yz);
    }
}
