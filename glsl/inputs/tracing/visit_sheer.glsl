// A traversal looks for the nearest hit; or, where `triangle` is SHADOW, for all that takes light from a ray: anything solid
// blocks it, layers of cloth are noted, and more of them than eight block it too. As in inputs/tracing/visit_attenuate.glsl a hit
// counts in the leaf that it lies in, and layers are reckoned together, afterwards.
#include "trace/shared.glsl"

const uint SHADOW = 0xfffffffeu;
const int NOTED_LAYERS = 8;

struct Visit {
    float t;          // nothing beyond matters; 0: no light is left
    uint triangle;
    vec2 weights;     // barycentric coordinates of the second and third corner
    int layers;       // noted
    uvec4 latest;     // their triangles, the latest first; shifted along, because an indexed array goes through memory
    uvec4 earlier;
};

Visit closest_visit() { return Visit(3e38, NO_TRIANGLE, vec2(0.0), 0, uvec4(0u), uvec4(0u)); }

Visit shadow_visit(float reach) { return Visit(reach, SHADOW, vec2(0.0), 0, uvec4(NO_TRIANGLE), uvec4(NO_TRIANGLE)); }

float t_limit(Visit visit) { return visit.t; }

void accept(inout Visit visit, Ray ray, uint tag, vec4 hit, vec2 window) {
    uint triangle = tag & ~SOLID;
    bool nearer = hit.x > ray.t_min && (hit.x < visit.t || hit.x == visit.t && triangle < visit.triangle);
    if (visit.triangle != SHADOW) {
        visit.t = nearer ? hit.x : visit.t;
        visit.weights = nearer ? hit.yz : visit.weights;
        visit.triangle = nearer ? triangle : visit.triangle;
        return;
    }
    // Numbers of solid triangles and of a ground are larger than others.
    float first = max(window.x - 1e-5 * (1.0 + window.x), ray.t_min);
    float last = min(window.y + 1e-5 * (1.0 + window.y), visit.t);
    if (!(hit.x > first && hit.x < last)) return;
    // A long thin triangle lies in several leaves (glcloth/accel/needles.py).
    if (any(equal(visit.latest, uvec4(triangle))) || any(equal(visit.earlier, uvec4(triangle)))) return;
    bool blocked = tag >= 0x7fffffffu || visit.layers == NOTED_LAYERS;
    visit.t = blocked ? 0.0 : visit.t;
    visit.earlier = uvec4(visit.latest.w, visit.earlier.xyz);
    visit.latest = uvec4(triangle, visit.latest.xyz);
    visit.layers += 1;
}
