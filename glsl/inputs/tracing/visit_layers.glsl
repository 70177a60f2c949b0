// A traversal looks for the layers of cloth along a ray in their order, up to the first hit that is not cloth, or
// `most_layers` of them. One traversal then serves the ray and all that goes on straight behind it. A hit that is found
// in the leaf it lies in is the nearest behind the one before; of hits at the same t the lowest triangle counts.
#include "trace/shared.glsl"
#define SETTLES

uniform int most_layers;

struct Visit {
    float t;
    uint tag;       // of the triangle
    float from;     // hits count beyond
    int inside;     // how many lie in the present leaf
    int layers;     // settled so far
    int at;         // where the first hit is stored
    float t_max;    // 0 when enough was met
};

float t_limit(Visit visit) { return min(visit.t, visit.t_max); }

void accept(inout Visit visit, Ray ray, uint tag, vec4 hit, vec2 window) {
    bool counts = hit.x > visit.from;
    visit.inside += counts && hit.x <= window.y ? 1 : 0;
    if (counts && (hit.x < visit.t || hit.x == visit.t && (tag & ~SOLID) < (visit.tag & ~SOLID))) {
        visit.t = hit.x;
        visit.tag = tag;
    }
}

// Stores the hit if it lies before t_1; true if the ray goes on and the leaf holds another one.
bool settle(inout Visit visit, float t_1) {
    bool others = visit.inside > 1;
    visit.inside = 0;
    bool here = visit.tag != NO_TRIANGLE && visit.t <= t_1;
    if (here) {
        layer_out[2 * (visit.at + visit.layers)] =
            uvec2(floatBitsToUint(visit.t), visit.tag & ~SOLID);
        ++visit.layers;
        visit.t_max = (visit.tag & SOLID) != 0u || visit.layers == most_layers ? 0.0 : visit.t_max;
        visit.from = behind_layer(visit.t);
        visit.t = visit.t_max;
        visit.tag = NO_TRIANGLE;
    }
    return here && others && visit.t_max > 0.0;
}
