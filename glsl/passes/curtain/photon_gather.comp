#version 430
// Irradiance at some of the photons, or at other points, by the density of the photons around. At the rims of a surface the
// disc that they are sought in is smaller by what lies beyond.   [Jensen 2001, section 7.5; Christensen 1999, "Faster photon
// map global illumination"]
#include "inputs/accel/nearest_points.glsl"
layout(local_size_x = 64) in;
#include "inputs/gpu/item.glsl"
uniform usamplerBuffer queries;    // points as the tree has them, with the place that they lie on: every `stride`-th is taken
uniform usamplerBuffer rim_lists;  // of each place its first rim, and how many
uniform samplerBuffer rims;        // two texels each: where they begin and end
layout(std430) readonly buffer Radii { vec2 radius[]; };     // squared, passes/curtain/photon_radius.comp
layout(std430) writeonly buffer Points { uvec4 point[]; };  // as the queries; it carries irradiance and the area that holds the neighbours
uniform int query_count;
uniform int stride;

const float LEAST_LEFT = 0.03;     // of the disc

void main() {
    int i = item();
    if (i >= query_count) return;
    uvec4 place = texelFetch(queries, 2 * stride * i);
    int surface = int(texelFetch(queries, 2 * stride * i + 1).w);
    vec3 p = uintBitsToFloat(place.xyz);
    vec3 n = from_octahedral(unpackSnorm2x16(place.w));
    Search search = begun(p, n, radius[i].x, false);
    search_points(search);
    float r = sqrt(search.reach);
    uvec2 list = texelFetch(rim_lists, surface).xy;
    float left = 1.0;
    uint k = 0u;
    do {
        if (k < list.y) {
            int at = 2 * int(list.x + k);
            left -= cut_share(p, texelFetch(rims, at).xyz, texelFetch(rims, at + 1).xyz, n, r);
        }
        ++k;
    } while (k < list.y);
    float area = search.reach * max(left, LEAST_LEFT);
    vec3 E = search.sum / (0.5 * PI * area);
    point[2 * i] = place;
    point[2 * i + 1] = uvec4(floatBitsToUint(E), floatBitsToUint(area));
}
