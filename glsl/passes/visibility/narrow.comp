#version 430
// Rays into four narrow Gaussians from the covered pixels whose triangles' corners disagree on them.   [own]
#include "inputs/picture/gbuffer.glsl"
#include "inputs/picture/gbuffer_point.glsl"
// Defines: SHEER, where cloth lets light through.
#include "sight.glsl"
layout(local_size_x = 8, local_size_y = 8) in;
uniform usamplerBuffer mean_data;      // passes/visibility/spread.comp
uniform isamplerBuffer corner_index;
uniform samplerBuffer direction_data;  // equal shares of each Gaussian
layout(rgba8) uniform image2DArray seen;
uniform int group_count;               // of mean_data
uniform int layer;                     // of `seen`, and group of mean_data
uniform ivec4 begin;                   // of each Gaussian's directions; below 0: none
uniform int direction_count;           // of each
uniform int first_tile;                // of the picture, row by row
uniform int row_tiles;

const int FIRST = 5;       // rays that may tell that there is no edge
const float EDGE = 0.03;   // of V: vertices that see more of a light than that, or less than all but that, are at no edge

// Whether vertices that see these shares may hide a shadow's edge from the pixels between them.
bool at_edge(vec3 V) {
    float low = min(min(V.x, V.y), V.z), high = max(max(V.x, V.y), V.z);
#ifdef SHEER
    return high - low > EDGE;  // all may see the light through the same cloth
#else
    return high > EDGE && low < 1.0 - EDGE;
#endif
}

float seen_of(vec3 x, vec3 N, int first, float otherwise) {
    vec2 sum = vec2(0.0);
#ifdef SHEER
    vec2 range = vec2(1.0, 0.0);
#endif
    int d = first;
    do {
        vec3 omega = texelFetch(direction_data, d).xyz;
        float w = clamp(8.0 * dot(omega, N), 0.0, 1.0);
        if (w > 0.0) {
#ifdef SHEER
            Visit first_hit;
            float left = seen_along(x, omega, first_hit);
            range = vec2(min(range.x, left), max(range.y, left));
            sum += w * vec2(left, 1.0);
#else
            Visit visit = Visit(3e38, NO_TRIANGLE, vec2(0.0));
            Ray ray = make_ray(x, omega, 0.0, 3e38);
            traverse(ray, visit);
            sum += w * vec2(visit.t > 0.0 ? 1.0 : 0.0, 1.0);
#endif
        }
        // The outer ones come first: where they agree, no edge crosses the light.
#ifdef SHEER
        if (++d == first + FIRST && range.y - range.x < EDGE) break;
#else
        if (++d == first + FIRST && (sum.x == 0.0 || sum.x == sum.y)) break;
#endif
    } while (d < first + direction_count);
    return sum.y > 0.0 ? sum.x / sum.y : otherwise;
}

void main() {
    int tile = first_tile + int(gl_WorkGroupID.x);
    ivec2 pixel = 8 * ivec2(tile % row_tiles, tile / row_tiles) + ivec2(gl_LocalInvocationID.xy);
    if (any(greaterThanEqual(pixel, textureSize(frame_N, 0)))) return;
    vec4 N = texelFetch(frame_N, pixel, 0);
    if (N.w == 0.0) return;
    int first = 3 * triangle_at(pixel);
    ivec3 corner = ivec3(texelFetch(corner_index, first).x, texelFetch(corner_index, first + 1).x,
        texelFetch(corner_index, first + 2).x);
    corner = (2 * corner + (texelFetch(frame_x, pixel, 0).w < 0.0 ? 1 : 0)) * group_count + layer;
    vec4 a = unpackUnorm4x8(texelFetch(mean_data, corner.x).x), b = unpackUnorm4x8(texelFetch(mean_data, corner.y).x),
        c = unpackUnorm4x8(texelFetch(mean_data, corner.z).x);
    ivec3 at = ivec3(pixel, layer);
    vec4 V = imageLoad(seen, at);
    vec3 x = origin_at(pixel);
    ivec4 begins = begin;
    int n = 0;
    do {
        if (begins.x >= 0 && at_edge(vec3(a.x, b.x, c.x))) V.x = seen_of(x, N.xyz, begins.x, V.x);
        V = V.yzwx;
        a = a.yzwx;
        b = b.yzwx;
        c = c.yzwx;
        begins = begins.yzwx;
    } while (++n < 4);
    imageStore(seen, at, V);
}
