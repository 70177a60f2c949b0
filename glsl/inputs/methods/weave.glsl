// How much of each tangent a pixel shows, and in which colours: maps of one repeat of a weave, averaged over the pixel.   [own]
//   L = sum_t rel_t w_t M P f / Q with Q of the whole weave; the mean of rel_t is 1, so that of the pixels is the far field's.
// Stands for inputs/methods/threads.glsl. See glcloth/methods/weave_maps.py.
#include "inputs/methods/rel.glsl"
#include "inputs/picture/pixel_uv.glsl"
#define SUMS vec4
#define COLORED(sums, omega) woven(sums, omega)

const float MOST_TAPS = 8.0;
uniform sampler2DArray weave_map;    // rel; then the rolls of warp and weft times their shares
uniform sampler2DArray color_map;    // of warp and of weft: colour times share, share
uniform bool colored;                // whether threads have colours of their own
uniform vec2 weave_repeats, color_repeats;  // 1/m, along u and v
uniform vec4 weave_share[GROUPS];    // in W's normaliser; unused ones 0
uniform vec4 weave_yarn[GROUPS];     // 0 or 1
uniform vec3 weave_A[2];
uniform float roll;

vec3 pixel_A[2];
vec2 pixel_roll;  // how far what is seen of warp and weft turns to the side

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
    for (int g = 0; g < GROUPS; ++g) rel[g] = vec4(0.0);
    vec2 rolls = vec2(0.0);
    float tap = 0.0;
    do {
        vec2 place = at.uv * weave_repeats + way * ((tap + 0.5) / taps.x - 0.5);
        for (int g = 0; g < GROUPS; ++g) rel[g] += textureLod(weave_map, vec3(place, float(g)), taps.y) / taps.x;
        rolls += textureLod(weave_map, vec3(place, float(GROUPS)), taps.y).xy / taps.x;
    } while (++tap < taps.x);
    vec2 share = vec2(0.0);
    for (int g = 0; g < GROUPS; ++g) {
        vec4 w = weave_share[g] * rel[g];
        float of_weft = dot(w, weave_yarn[g]);
        share += vec2(dot(w, vec4(1.0)) - of_weft, of_weft);
    }
    pixel_roll = roll * clamp(rolls / max(share, 1e-4), -1.0, 1.0);
    fetch_colors(at);
}

// What the sums of surface and volume terms, of warp and of weft, are in light from omega: the side of a yarn that turns to
// the light is brighter by as much as the other one is darker.
vec3 woven(vec4 sums, vec3 omega) {
    vec2 f = 1.0 + lean(omega) * pixel_roll;
    return (sums.x + pixel_A[0] * sums.y) * f.x + (sums.z + pixel_A[1] * sums.w) * f.y;
}
