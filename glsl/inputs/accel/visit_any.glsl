// A traversal looks for any hit.
#include "trace/shared.glsl"

struct Visit {
    float t;          // nothing beyond matters: t_max, or 0 after a hit
    uint triangle;
    vec2 weights;
};

float t_limit(Visit visit) { return visit.t; }

void accept(inout Visit visit, Ray ray, uint tag, vec4 hit, vec2 window) {
    if (hit.x > ray.t_min && hit.x < visit.t) visit = Visit(0.0, tag & ~SOLID, hit.yz);
}
