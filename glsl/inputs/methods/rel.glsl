// How much of each tangent a pixel shows, over its share of the whole cloth.   [own]
// Defines: WEAVE, where a pixel may show threads; then GROUPS, vec4s that hold the tangents, and LANE_COUNT of them in each.
#ifdef WEAVE
vec4 rel[GROUPS];

float rel_of(int t) { return rel[t / LANE_COUNT][t % LANE_COUNT]; }
#endif
