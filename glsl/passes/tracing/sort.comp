#version 430
// Parts the rays of one generation: those that hit cloth from the front of the list, all others from its back. Each kind is
// shaded by a dispatch of its own, because a software rasteriser executes the code of both for every ray that it takes
// together. An invocation takes PART_SHARE neighbours, so that it meets the others at the two counters only once. It also
// counts the work groups of these dispatches, so that the CPU need not wait for the numbers.
#include "trace/shared.glsl"
#include "inputs/tracing/counts.glsl"
layout(local_size_x = 64) in;
#include "inputs/gpu/item.glsl"
uniform usamplerBuffer layers;           // (t, triangle, v, w)
uniform usamplerBuffer attribute_data;  // one texel: material, -
uniform samplerBuffer weights;          // (weight, layer)
layout(std430) writeonly buffer Order { uint order[]; };
uniform int capacity;  // of the queue

// A place for `rays` more in one of the two lists; the column of work groups that the last one begins is counted.
uint place_in(int list, int groups, uint rays) {
    uint first = atomicAdd(count[list], rays), column_rays = count[COLUMN_RAYS];
    uint begun = (first + rays + column_rays - 1u) / column_rays - (first + column_rays - 1u) / column_rays;
    if (begun > 0u) atomicAdd(count[groups], begun);
    return first;
}

void main() {
    int ray_count = int(count[RAYS]), front_count = int(count[FRONT]);
    int begin = PART_SHARE * item();
    int end = min(begin + PART_SHARE, ray_count);
    if (begin >= end) return;
    int aside = capacity - ray_count;  // how far off the second run lies
    uint cloth = 0u;                       // a bit for each ray
    int place = begin;
    do {
        int i = place < front_count ? place : place + aside;
        uint triangle = texelFetch(layers, floatBitsToInt(texelFetch(weights, i).a)).y;
        bool hit = triangle != NO_TRIANGLE;
        uint material = texelFetch(attribute_data, hit ? int(triangle) : 0).x;
        cloth |= hit && material == 0u ? 1u << uint(place - begin) : 0u;
        ++place;
    } while (place < end);
    uint on_cloth = uint(bitCount(cloth));
    uint first = place_in(ON_CLOTH, CLOTH_GROUPS, on_cloth);
    uint last = uint(ray_count) - 1u - place_in(ELSEWHERE, OTHER_GROUPS, uint(end - begin) - on_cloth);
    place = begin;
    do {
        bool here = (cloth >> uint(place - begin) & 1u) != 0u;
        order[here ? first : last] = uint(place < front_count ? place : place + aside);
        first += here ? 1u : 0u;
        last -= here ? 0u : 1u;
        ++place;
    } while (place < end);
}
