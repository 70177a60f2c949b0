// How much of each tangent a pixel shows, over its share of the whole cloth, and how far that turns to the side.   [own]
// Defines: WEAVE, where a pixel may show threads; then GROUPS, vec4s that hold the tangents, and LANE_COUNT of them in each.
#include "core/footprint.glsl"
#ifdef WEAVE
vec4 rel[GROUPS];
vec4 turn[GROUPS];  // rel times the sine of the yarn's roll; both are averaged over the pixel, so that their means are exact

// (rel, turn) of tangent t. Chosen without indexing: arrays that are indexed by variables leave the registers, which costs
// llvmpipe more than all fetches of threads.
vec2 rel_and_turn(int t) {
    vec4 lane = vec4(equal(ivec4(0, 1, 2, 3), ivec4(t % LANE_COUNT)));
    int group = t / LANE_COUNT;
    vec2 found = vec2(0.0);
    for (int g = 0; g < GROUPS; ++g) found += g == group ? vec2(dot(rel[g], lane), dot(turn[g], lane)) : vec2(0.0);
    return found;
}

// What a pixel shows of a tangent of yarn j in light from omega: the side of a yarn that turns to the light is brighter by as
// much as the other one is darker.
float seen_of(vec2 rel_and_turn, int j, vec3 omega) { return rel_and_turn.x + lean(omega)[j] * rel_and_turn.y; }
#endif
