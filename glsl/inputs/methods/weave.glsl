// How much of each tangent a pixel shows, and in which colours: maps of one repeat of a weave, averaged over the pixel.   [own]
//   L = sum_t rel_t w_t M P f / Q with Q of the whole weave; the mean of rel_t is 1, so that of the pixels is the far field's.
// Stands for inputs/methods/threads.glsl. See glcloth/methods/weave_maps.py.
#include "inputs/methods/rel.glsl"
#include "inputs/picture/pixel_uv.glsl"
#define SUMS vec4
#define IN_LIGHT(sums, omega) woven(sums + lean(omega).xxyy * turned)
#define COLORED(sums) woven(sums)

const float MOST_TAPS = 8.0;
uniform sampler2DArray weave_map;    // GROUPS layers of rel, then of turn
uniform sampler2DArray color_map;    // of warp and of weft: colour times share, share
uniform bool colored;                // whether threads have colours of their own
uniform vec2 weave_repeats, color_repeats;  // 1/m, along u and v
uniform vec3 weave_A[2];

vec3 pixel_A[2];

void fetch_colors(PixelUv at) {
    pixel_A[0] = weave_A[0];
    pixel_A[1] = weave_A[1];
    if (!colored) return;
    vec2 x = at.x * color_repeats, y = at.y * color_repeats, size = vec2(textureSize(color_map, 0).xy);
    vec2 taps = taps_and_level(x * size, y * size, MOST_TAPS);
    vec2 way = dot(x * size, x * size) > dot(y * size, y * size) ? x : y;
    vec4 warp = vec4(0.0), weft = vec4(0.0);
    float tap = 0.0;
    do {
        vec2 place = at.uv * color_repeats + way * ((tap + 0.5) / taps.x - 0.5);
        warp += textureLod(color_map, vec3(place, 0.0), taps.y);
        weft += textureLod(color_map, vec3(place, 1.0), taps.y);
    } while (++tap < taps.x);
    pixel_A[0] = warp.a > 1e-4 ? warp.rgb / warp.a : weave_A[0];
    pixel_A[1] = weft.a > 1e-4 ? weft.rgb / weft.a : weave_A[1];
}

void fetch_weave(ivec2 pixel) {
    PixelUv at = pixel_uv(pixel);
    vec2 x = at.x * weave_repeats, y = at.y * weave_repeats, size = vec2(textureSize(weave_map, 0).xy);
    vec2 taps = taps_and_level(x * size, y * size, MOST_TAPS);
    vec2 way = dot(x * size, x * size) > dot(y * size, y * size) ? x : y;
    for (int g = 0; g < GROUPS; ++g) rel[g] = turn[g] = vec4(0.0);
    float tap = 0.0;
    do {
        vec2 place = at.uv * weave_repeats + way * ((tap + 0.5) / taps.x - 0.5);
        for (int g = 0; g < GROUPS; ++g) {
            rel[g] += textureLod(weave_map, vec3(place, float(g)), taps.y) / taps.x;
            turn[g] += textureLod(weave_map, vec3(place, float(g + GROUPS)), taps.y) / taps.x;
        }
    } while (++tap < taps.x);
    fetch_colors(at);
}

// The colour of sums of surface and volume terms, of warp and of weft.
vec3 woven(vec4 sums) {
    return sums.x + pixel_A[0] * sums.y + sums.z + pixel_A[1] * sums.w;
}
