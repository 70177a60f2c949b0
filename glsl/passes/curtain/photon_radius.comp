#version 430
// How far the wanted number of photons around some of them, or around other points, reaches: one search, which narrows it down.
#include "inputs/accel/nearest_points.glsl"
layout(local_size_x = 64) in;
#include "inputs/gpu/item.glsl"
uniform usamplerBuffer queries;               // points as the tree has them: every `stride`-th is taken
layout(std430) buffer Radii { vec2 radius[]; };  // squared; and 1 where it is known well
uniform int query_count;
uniform int stride;
uniform bool begins;

void main() {
    int i = item();
    if (i >= query_count) return;
    vec2 before = begins ? vec2(nearest_most, 0.0) : radius[i];
    if (before.y > 0.0) return;
    uvec4 place = texelFetch(queries, 2 * stride * i);
    Search search = begun(uintBitsToFloat(place.xyz), from_octahedral(unpackSnorm2x16(place.w)), before.x, true);
    bool again = shrinks(search);
    radius[i] = vec2(search.reach, again ? 0.0 : 1.0);
}
