#version 430
// Parts the rays of one generation: those that hit cloth from the front of the list, all others from its back. Each kind is
// shaded by a dispatch of its own, because a software rasteriser executes the code of both for every ray that it takes
// together.
#include "trace/shared.glsl"
layout(local_size_x = 64) in;
layout(binding = 8) uniform usamplerBuffer layers;           // (t, triangle, v, w)
layout(binding = 13) uniform usamplerBuffer attribute_data;  // one texel: material, -
layout(binding = 15) uniform samplerBuffer weights;          // (weight, layer)
layout(std430, binding = 0) writeonly buffer Order { uint order[]; };
layout(std430, binding = 5) buffer Counts { uint count[]; };  // (4) on cloth, (5) others
uniform int ray_count;
uniform int front_count;
uniform int back_first;
#include "passes/claim.glsl"

void main() {
    begin_claims();
    int place = int(gl_GlobalInvocationID.x);
    bool live = place < ray_count;
    int i = live ? place : 0;
    if (i >= front_count) i += back_first - front_count;
    uint triangle = texelFetch(layers, floatBitsToInt(texelFetch(weights, i).a)).y;
    bool hit = triangle != NO_TRIANGLE;
    bool cloth = hit && texelFetch(attribute_data, hit ? int(triangle) : 0).x == 0u;
    uint k = live ? claim(cloth ? 4 : 5) : 0u;
    settle_claims();
    if (live) order[cloth ? place_of(4, k) : uint(ray_count) - 1u - place_of(5, k)] = uint(i);
}
