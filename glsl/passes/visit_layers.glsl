// What a traversal looks for: the layers of cloth along a ray in their order, up to the first hit that is not cloth, or
// `most_layers` of them. One traversal then serves the ray and all that goes on straight behind it. A hit that is found
// in the leaf it lies in is the nearest behind the one before; of hits at the same t the lowest triangle counts.
#include "trace/shared.glsl"
#define SETTLES

uniform int most_layers;

struct Visit {
    float t;
    uint tag;       // of the triangle
    vec2 weights;   // barycentric coordinates of the second and third corner
    float from;     // hits count beyond
    int layers;     // settled so far
    int at;         // where the first hit is stored
    float t_max;    // 0 when enough was met
};

float reach(Visit visit) { return min(visit.t, visit.t_max); }

void meet(inout Visit visit, Ray ray, uint tag, vec4 hit, vec2 window) {
    if (hit.x > visit.from && (hit.x < visit.t || hit.x == visit.t && (tag & ~SOLID) < (visit.tag & ~SOLID))) {
        visit.t = hit.x;
        visit.tag = tag;
        visit.weights = hit.yz;
    }
}

// Stores the hit if it lies before t_1; true if the ray goes on.
bool settle(inout Visit visit, float t_1) {
    bool here = visit.tag != NO_TRIANGLE && visit.t <= t_1;
    if (here) {
        layer_out[visit.at + visit.layers] =
            uvec4(floatBitsToUint(visit.t), visit.tag & ~SOLID, floatBitsToUint(visit.weights));
        ++visit.layers;
        visit.t_max = (visit.tag & SOLID) != 0u || visit.layers == most_layers ? 0.0 : visit.t_max;
        visit.from = behind_layer(visit.t);
        visit.t = visit.t_max;
        visit.tag = NO_TRIANGLE;
    }
    return here && visit.t_max > 0.0;
}
