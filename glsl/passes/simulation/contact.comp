#version 430
// Contact of the cloth with itself in one substep: how far each vertex should move, the mean over its contacts (a sum
// would push too far where several vertices of one layer meet it). MEETS: with other cloths, too. Read by passes/simulation/advance.comp. One invocation per vertex.
#include "simulate/shared.glsl"
#include "simulate/contact.glsl"
layout(local_size_x = 64) in;
#include "inputs/gpu/item.glsl"
uniform samplerBuffer Position;
uniform samplerBuffer Previous;
layout(std430) writeonly buffer Contact { vec4 shift[]; };
uniform isamplerBuffer Near;
uniform isamplerBuffer NearCount;
uniform int vertex_count;
#ifdef MEETS
layout(std430) readonly buffer Met { vec4 met[]; };  // passes/simulation/meet.comp
#endif
uniform float gap;   // m
uniform float mu;
#if FOLDS == 1
uniform int columns;
uniform vec2 spacing;   // m, along a row and down a column
uniform float least;    // share of their distance in the flat cloth that neighbours keep
uniform float most;     // m: further contact moves no vertex in a substep, or threads would be stretched by it
#endif

void main() {
    int index = item();
    if (index >= vertex_count) {
        return;
    }
    vec4 here = texelFetch(Position, index);
    vec3 moved = here.xyz - texelFetch(Previous, index).xyz;
    vec3 sum = vec3(0.0);
    float contacts = 0.0;
#ifdef MEETS
    sum = met[index].xyz;
    contacts = met[index].w;
#endif
    int count = texelFetch(NearCount, index).x;
    int k = 0;
    // The test stands at the end: a software rasteriser executes a loop's body once more than one at its top wants.
    do {
        // Nothing near: the vertex itself, which is in no contact with itself.
        int other = k < count ? texelFetch(Near, index * MAX_NEAR + k).x : index;
        vec4 there = texelFetch(Position, other);
        vec3 e = here.xyz - there.xyz;
        bool touches = other != index && dot(e, e) < gap * gap;
        vec3 slide = moved - (there.xyz - texelFetch(Previous, other).xyz);
        sum += touches ? part(here.xyz, there.xyz, here.w, there.w, gap, slide, mu) : vec3(0.0);
        contacts += touches ? 1.0 : 0.0;
        k++;
    } while (k < count);
#if FOLDS == 1
    int i = index / columns;
    int j = index - i * columns;
    int last_row = vertex_count / columns - 1;
    for (int n = 0; n < 25; n++) {
        ivec2 step = ivec2(n % 5 - 2, n / 5 - 2);
        ivec2 at = ivec2(j, i) + step;
        bool there_is = n != 12 && at.x >= 0 && at.y >= 0 && at.x < columns && at.y <= last_row;
        int other = there_is ? at.y * columns + at.x : index;
        vec4 there = texelFetch(Position, other);
        float keep = least * length(vec2(step) * spacing);
        vec3 e = here.xyz - there.xyz;
        bool folded = there_is && dot(e, e) < keep * keep;
        sum += folded ? part(here.xyz, there.xyz, here.w, there.w, keep, vec3(0.0), 0.0) : vec3(0.0);
        contacts += folded ? 1.0 : 0.0;
    }
#endif
    vec3 mean = contacts > 0.0 ? sum / contacts : vec3(0.0);
#if FOLDS == 1
    mean *= min(1.0, most / max(length(mean), 1e-9));
#endif
    shift[index] = vec4(mean, 0.0);
}
