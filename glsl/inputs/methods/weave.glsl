// How much of each tangent a pixel shows, and in which colours: maps of one repeat of a weave, averaged over the pixel.   [own]
//   L = sum_t rel_t w_t M P f / Q with Q of the whole weave; the mean of rel_t is 1, so that of the pixels is the far field's.
// Stands for inputs/methods/threads.glsl. See glcloth/methods/weave_maps.py.
#include "inputs/methods/rel.glsl"
#include "inputs/picture/pixel_uv.glsl"
#define SUMS vec4
#define ADD_LIGHT(light, omega) L += (light) * woven(sum_tangents(lean(omega)))
#define COLORED(sums) woven(sums)

// A uniform: compilers unroll a loop whose limit they can tell, and a software rasteriser then runs all its rounds.
uniform float most_taps;
uniform sampler2DArray weave_map;    // GROUPS layers of rel, then of turn; then one whose first value is 1 in holes
uniform float hole_mean;             // the mean of that
uniform sampler2DArray color_map;    // of warp and of weft: colour times share, share
uniform bool colored;                // whether threads have colours of their own
uniform vec2 weave_repeats, color_repeats;  // 1/m, along u and v
uniform vec3 weave_A[2];
uniform float far_footprint;  // metres of cloth, the shorter side of a pixel from which on it shows no threads

uniform sampler2D noise_map;
uniform vec2 yarns;       // picks and ends of a metre
uniform vec4 irregular;   // yarns: how far yarns wander, and along how many; deviation of the light of single yarns, of fibres
uniform vec4 fibres;      // strands across a yarn, their length over their width; sideways way of fibres along warp and weft

vec3 pixel_A[2];
vec4 strands;  // by how much surface and volume terms of warp and weft are brighter

void fetch_colors(PixelUv at) {
    pixel_A[0] = weave_A[0];
    pixel_A[1] = weave_A[1];
    if (!colored) return;
    vec2 x = at.x * color_repeats, y = at.y * color_repeats, size = vec2(textureSize(color_map, 0).xy);
    vec2 taps = taps_and_level(x * size, y * size, most_taps);
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

// -- irregularity: every factor has the mean 1, and wandering yarns wander alike wherever they are in the repeat ------------

// Four values of mean 0 and deviation 1; `at`: in texels, x and y: how that changes to the next pixels.
vec4 noise(vec2 at, vec2 x, vec2 y) {
    return textureLod(noise_map, at / float(textureSize(noise_map, 0).x), taps_and_level(x, y, 1.0).y);
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
    return PixelUv(q / yarns, at.x, at.y);
}

// How much of a pixel that covers so much of the cloth shows threads. What a picture's pixels are too coarse to draw would
// only make patterns of its own.
float threads_seen(PixelUv at) {
    return clamp(2.5 - 2.5 * min(length(at.x), length(at.y)) / far_footprint, 0.0, 1.0);
}

// The share of a pixel that is a hole between threads; its mean is `hole_mean`.
float hole_share(ivec2 pixel) {
    PixelUv at = wandered(pixel_uv(pixel));
    vec2 x = at.x * weave_repeats, y = at.y * weave_repeats, size = vec2(textureSize(weave_map, 0).xy);
    vec2 taps = taps_and_level(x * size, y * size, most_taps);
    vec2 way = dot(x * size, x * size) > dot(y * size, y * size) ? x : y;
    float tap = 0.0, hole = 0.0;
    do {
        vec2 place = at.uv * weave_repeats + way * ((tap + 0.5) / taps.x - 0.5);
        hole += textureLod(weave_map, vec3(place, float(2 * GROUPS)), taps.y).r;
    } while (++tap < taps.x);
    return mix(hole_mean, hole / taps.x, threads_seen(at));
}

void fetch_weave(ivec2 pixel) {
    PixelUv at = wandered(pixel_uv(pixel));
    vec2 x = at.x * weave_repeats, y = at.y * weave_repeats, size = vec2(textureSize(weave_map, 0).xy);
    vec2 taps = taps_and_level(x * size, y * size, most_taps);
    vec2 way = dot(x * size, x * size) > dot(y * size, y * size) ? x : y;
#define NO_REL(g) rel[g] = turn[g] = vec4(0.0);
#define ADD_REL(g) rel[g] += textureLod(weave_map, vec3(place, float(g)), taps.y); \
    turn[g] += textureLod(weave_map, vec3(place, float(g + GROUPS)), taps.y);
#define MEAN_REL(g) rel[g] = mix(vec4(1.0), share * rel[g], seen); turn[g] *= seen * share;
    EACH_GROUP(NO_REL)
    float tap = 0.0, share = 1.0 / taps.x;
    do {
        vec2 place = at.uv * weave_repeats + way * ((tap + 0.5) * share - 0.5);
        EACH_GROUP(ADD_REL)
    } while (++tap < taps.x);
    float seen = threads_seen(at);
    EACH_GROUP(MEAN_REL)
    strands = mix(vec4(1.0), strands, seen);
    fetch_colors(at);
    pixel_A[0] = mix(weave_A[0], pixel_A[0], seen);
    pixel_A[1] = mix(weave_A[1], pixel_A[1], seen);
}

// The colour of sums of surface and volume terms, of warp and of weft.
vec3 woven(vec4 sums) {
    sums *= strands;
    return sums.x + pixel_A[0] * sums.y + sums.z + pixel_A[1] * sums.w;
}
