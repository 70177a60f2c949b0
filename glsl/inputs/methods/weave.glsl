// How much of each tangent a pixel shows, and in which colours: maps of one repeat of a weave, averaged over the pixel.   [own]
//   L = sum_t rel_t w_t M P f / Q with Q of the whole weave; the mean of rel_t is 1, so that of the pixels is the far field's.
// Stands for inputs/methods/threads.glsl. See glcloth/methods/weave_maps.py.
// Defines: ONE_COLOR, where no thread has a colour of its own: a software rasteriser reads maps of colours even if not `colored`.
#include "inputs/methods/rel.glsl"
#include "inputs/methods/levels.glsl"
#include "inputs/picture/pixel_uv.glsl"
#ifdef PRINT
#include "inputs/picture/print.glsl"
#endif
#ifdef RELIEF
#include "core/disk.glsl"
#include "inputs/methods/relief.glsl"
uniform sampler2DArray relief_table;  // means of rel, of turn and of holes, each at several levels; omega as a disk
uniform vec3 relief_levels;  // the mip level of the first, how many, and how many from one mip level to the next
#endif
#define SUMS vec4
#define ADD_LIGHT(light, omega) L += (light) * woven(sum_tangents(lean(omega)))
#define COLORED(sums) woven(sums)

// A uniform: compilers unroll a loop whose limit they can tell, and a software rasteriser then runs all its rounds.
uniform float most_taps;
uniform float hole_mean;             // the share of holes
uniform bool colored;                // whether threads have colours of their own
uniform vec3 weave_A[2];
uniform float far_footprint;  // metres of cloth, the shorter side of a pixel from which on it shows no threads

uniform sampler2DArray noise_levels;
uniform vec4 noise_rects[MOST_LEVELS];
uniform vec2 noise_sizes;
uniform vec3 noise_steps;
uniform vec2 yarns;       // picks and ends of a metre
uniform vec4 irregular;   // yarns: how far yarns wander, and along how many; deviation of the light of single yarns, of fibres
uniform vec4 fibres;      // strands across a yarn, their length over their width; sideways way of fibres along warp and weft

vec3 pixel_A[2];
vec4 strands;  // by how much surface and volume terms of warp and weft are brighter

// 0..1: which of the versions of a map that are near a pixel's size it reads. Neighbours read other ones, so that no line shows
// where the size passes from one to the next.
float choice;

float choice_of(ivec2 pixel) {
    int x = pixel.x, y = pixel.y, even = x ^ y;
    int order = (even & 1) << 3 | (y & 1) << 2 | (even & 2) | (y & 2) >> 1;  // of a square of 4 x 4; the nearest for pixel 0
    return (float(order ^ 8) + 0.5) / 16.0;
}

// The places at which a pixel reads a map, in repeats: `count` of them on its longer side `along`, left and right of its middle.
// Where a pixel's size is between two mip levels each place has two rounds, of the finer one and of the coarser one.
struct Taps {
    float count, rounds;
    vec2 number;  // of the version of the map, share of the next
    float level;  // mip level
    vec2 along, across;
};

Taps pixel_taps(PixelUv at, vec2 repeats, vec2 size, vec3 steps) {
    vec2 x = at.x * repeats, y = at.y * repeats;
    vec2 taps = taps_and_level(x * size, y * size, most_taps);
    bool wide = dot(x * size, x * size) > dot(y * size, y * size);
    // One place filters a repeat of few texels badly: where pixels run in step with its harmonics, their mean is another one.
    float least = max(length(at.x * yarns), length(at.y * yarns)) > 0.2 ? 2.0 : 1.0;
    float count = max(taps.x, least);
    vec2 number = level_number(taps.y, steps, choice);
    return Taps(count, number.y > 0.0 ? 2.0 * count : count, number, taps.y, wide ? x : y, count > 1.0 ? (wide ? y : x) : vec2(0.0));
}

// The place of a round, and its share.
vec3 tap_place(Taps taps, vec2 middle, float n) {
    float tap = n < taps.count ? n : n - taps.count;
    vec2 place = middle + taps.along * ((tap + 0.5) / taps.count - 0.5) + taps.across * (fract(0.5 * tap) - 0.25);
    return vec3(place, (n < taps.count ? 1.0 - taps.number.y : taps.number.y) / taps.count);
}

float tap_number(Taps taps, float n) { return taps.number.x + (n < taps.count ? 0.0 : 1.0); }

// The way to what is seen at a place of the middle plane, in repeats.
vec2 shift_at(vec2 place, Level level, vec3 omega) {
#ifdef RELIEF
    return relief_shift(place, level, omega);
#else
    return vec2(0.0);
#endif
}

#ifdef RELIEF
// Where means are for a pixel that reads such versions of the maps: place on the disk, level.
vec3 mean_place(Taps taps, vec3 omega) {
    vec2 p = 0.5 + (0.5 - 0.5 / float(textureSize(relief_table, 0).x)) * to_disk(normalize(omega));
    float level = taps.number.y > 0.0 ? taps.level : level_of_number(taps.number.x, weave_steps);
    float row = floor(relief_levels.z * (level - relief_levels.x) + choice);
    return vec3(p, clamp(row, 0.0, relief_levels.y - 1.0));
}

vec4 mean_seen(int layer, vec3 place) {
    return textureLod(relief_table, vec3(place.xy, float(layer) * relief_levels.y + place.z), 0.0);
}
#endif

void fetch_colors(PixelUv at) {
    pixel_A[0] = weave_A[0];
    pixel_A[1] = weave_A[1];
#ifndef ONE_COLOR
    if (!colored) return;
    Taps taps = pixel_taps(at, color_repeats, color_sizes, color_steps);
    vec4 warp = vec4(0.0), weft = vec4(0.0);
    float tap = 0.0;
    do {
        vec3 place = tap_place(taps, at.uv * color_repeats, tap);
        float number = tap_number(taps, tap);
        warp += place.z * color_at(number, place.xy, 0);
        weft += place.z * color_at(number, place.xy, 1);
    } while (++tap < taps.rounds);
    pixel_A[0] = warp.a > 1e-4 ? warp.rgb / warp.a : weave_A[0];
    pixel_A[1] = weft.a > 1e-4 ? weft.rgb / weft.a : weave_A[1];
#ifdef PRINT
    // The map of threads' colours is not dyed in the mean of the print, as `weave_A` is.
    if (warp.a > 1e-4) pixel_A[0] *= print_mean;
    if (weft.a > 1e-4) pixel_A[1] *= print_mean;
#endif
#endif
}

// -- irregularity: every factor has the mean 1, and wandering yarns wander alike wherever they are in the repeat ------------

// Four values of mean 0 and deviation 1; `at`: in texels, x and y: how that changes to the next pixels.
vec4 noise(vec2 at, vec2 x, vec2 y) {
    float number = level_number(taps_and_level(x, y, 1.0).y, noise_steps, choice).x;
    return textureLod(noise_levels, vec3(place_in(noise_rects[int(number)], at / noise_sizes), 0.0), 0.0);
}

// The change of UVs, in yarns, where yarns wander; sets `strands`.
PixelUv wandered(PixelUv at) {
    vec2 q = at.uv * yarns, x = at.x * yarns, y = at.y * yarns;
    // Across the yarns a texel is no yarn, so that the noise does not run in step with them: that would shift the mean.
    vec2 s = vec2(1.0 / irregular.y, 0.763);
    q += irregular.x * vec2(noise(q.yx * s + 95.0, x.yx * s, y.yx * s).x, noise(q * s, x * s, y * s).x);
    s = vec2(0.125 / irregular.y, 1.0);
    vec2 light = vec2(noise(q * s + vec2(28.3, 0.0), x * s, y * s).y, noise(q.yx * s + vec2(181.3, 0.0), x.yx * s, y.yx * s).y);
    mat2 to_warp = mat2(1.0, -fibres.z, 0.0, 1.0), to_weft = mat2(-fibres.w, 1.0, 1.0, 0.0);  // twisted: (along, across)
    s = vec2(fibres.x / fibres.y, fibres.x);
    vec2 strand = vec2(noise(to_warp * q * s, to_warp * x * s, to_warp * y * s).z,
        noise(to_weft * q * s + 128.5, to_weft * x * s, to_weft * y * s).z);
    s *= 3.7;
    strand += vec2(noise(to_warp * q * s + 31.5, to_warp * x * s, to_warp * y * s).w,
        noise(to_weft * q * s + 77.5, to_weft * x * s, to_weft * y * s).w);
    strand *= 0.707 * irregular.w;
    strands = (1.0 + irregular.z * light).xxyy * (1.0 + strand.xxyy * vec4(1.0, 0.4, 1.0, 0.4));
    return PixelUv(q / yarns, at.x, at.y, at.omega);
}

// How much of a pixel that covers so much of the cloth shows threads. What a picture's pixels are too coarse to draw would
// only make patterns of its own.
float threads_seen(PixelUv at) {
    return clamp(2.5 - 2.5 * min(length(at.x), length(at.y)) / far_footprint, 0.0, 1.0);
}

// The share of a pixel that is a hole between threads; its mean is `hole_mean`.
float hole_share(ivec2 pixel) {
    choice = choice_of(pixel);
    PixelUv at = wandered(pixel_uv(pixel));
    Taps taps = pixel_taps(at, weave_repeats, weave_sizes, weave_steps);
    float tap = 0.0, hole = 0.0;
    do {
        vec3 place = tap_place(taps, at.uv * weave_repeats, tap);
        Level level = weave_level(tap_number(taps, tap));
        place.xy += shift_at(place.xy, level, at.omega);
        hole += place.z * weave_at(level, place.xy, 2 * GROUPS).r;
    } while (++tap < taps.rounds);
#ifdef RELIEF
    // Seen from the side holes are narrower; the far cloth's own thickness says so already.
    float mean = min(mean_seen(2 * GROUPS, mean_place(taps, at.omega)).r, 0.999);
    hole = mean < hole_mean ? hole + (1.0 - hole) * (hole_mean - mean) / (1.0 - mean) : hole * hole_mean / max(mean, 1e-6);
#endif
    return mix(hole_mean, hole, threads_seen(at));
}

void fetch_weave(ivec2 pixel) {
    choice = choice_of(pixel);
    PixelUv here = pixel_uv(pixel), at = wandered(here);
    Taps taps = pixel_taps(at, weave_repeats, weave_sizes, weave_steps);
#define NO_REL(g) rel[g] = turn[g] = vec4(0.0);
#define ADD_REL(g) rel[g] += place.z * weave_at(level, place.xy, g); \
    turn[g] += place.z * weave_at(level, place.xy, g + GROUPS);
#define MEAN_REL(g) rel[g] = mix(vec4(1.0), rel[g], seen); turn[g] *= seen;
    EACH_GROUP(NO_REL)
    float tap = 0.0;
    vec2 shift = vec2(0.0);
    do {
        vec3 place = tap_place(taps, at.uv * weave_repeats, tap);
        Level level = weave_level(tap_number(taps, tap));
        vec2 way = shift_at(place.xy, level, at.omega);
        shift += place.z * way;
        place.xy += way;
        EACH_GROUP(ADD_REL)
    } while (++tap < taps.rounds);
    float seen = threads_seen(at);
#ifdef RELIEF
    // From the side a repeat shows other shares of the tangents, and other sides of the yarns. The far cloth knows that already.
    vec3 means = mean_place(taps, at.omega);
#define EVEN_REL(g) { \
    vec4 mean = mean_seen(g, means), side = mean_seen(g + GROUPS, means); \
    rel[g] = with_mean(rel[g], mean, 1.0); \
    turn[g] = (turn[g] - side * rel[g]) / max(mean, 0.1); }
    EACH_GROUP(EVEN_REL)
    at.uv += shift / weave_repeats;
#endif
    EACH_GROUP(MEAN_REL)
    strands = mix(vec4(1.0), strands, seen);
    fetch_colors(at);
    pixel_A[0] = mix(weave_A[0], pixel_A[0], seen);
    pixel_A[1] = mix(weave_A[1], pixel_A[1], seen);
#ifdef PRINT
    vec3 ink = print_over_mean(here);
    pixel_A[0] *= ink;
    pixel_A[1] *= ink;
#endif
}

// The colour of sums of surface and volume terms, of warp and of weft.
vec3 woven(vec4 sums) {
    sums *= strands;
    return sums.x + pixel_A[0] * sums.y + sums.z + pixel_A[1] * sums.w;
}
#include "inputs/methods/even.glsl"
