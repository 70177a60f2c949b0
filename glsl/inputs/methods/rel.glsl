// How much of each tangent a pixel shows, over its share of the whole cloth, and how far that turns to the side.   [own]
// Defines: WEAVE, where a pixel may show threads; then GROUPS, vec4s that hold the tangents, and LANE_COUNT of them in each.
#include "core/footprint.glsl"
#ifdef WEAVE
vec4 rel[GROUPS];
vec4 turn[GROUPS];  // rel times the sine of the yarn's roll; both are averaged over the pixel, so that their means are exact

// What a pixel shows of tangent t of yarn j in light from omega: the side of a yarn that turns to the light is brighter by as
// much as the other one is darker.
float seen_of(int t, int j, vec3 omega) {
    return rel[t / LANE_COUNT][t % LANE_COUNT] + lean(omega)[j] * turn[t / LANE_COUNT][t % LANE_COUNT];
}
#endif
