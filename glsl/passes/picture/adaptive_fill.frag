#version 430
// Fills the picture from every second pixel of every second row, and lists the pixels where that is not good enough.   [own]
#include "inputs/picture/gbuffer.glsl"
layout(early_fragment_tests) in;  // a shader that writes to a buffer is tested late otherwise
uniform sampler2D coarse;
layout(std430) buffer Pixels {
    uvec3 groups;  // of 64 pixels, for the dispatch of passes/picture/shade_list.comp
    uint count;
    uint pixels[];  // x + 65536 y
};
uniform float tolerance;   // estimated relative error of luminance above which a pixel is shaded itself
uniform float bend_limit;  // sine of the angle between neighbours' normals above which a lobe could hide between them
out vec4 color;

const vec3 LUMINANCE = vec3(0.2126, 0.7152, 0.0722);

#ifdef WEAVE
// Where pixels show threads: what each tangent adds varies as slowly as cloth from afar, so it is that which is interpolated.
#include "inputs/methods/threads.glsl"  // that is weave.glsl or printed.glsl
uniform sampler2DArray terms;  // of passes/picture/shade_terms.frag
uniform float term_scale;      // of what they hold
uniform sampler2D far_depth;  // 1 where a pixel shows threads, or is not covered
uniform vec4 slot_yarn[GROUPS];

bool has_terms(ivec2 coarse_pixel) {
    return texelFetch(far_depth, min(2 * coarse_pixel, textureSize(far_depth, 0) - 1), 0).r == 1.0;
}

// The colours (red, green, blue) of tangents from red and blue for a luminance of 1.
mat3x4 with_green(vec4 red, vec4 blue) {
    return mat3x4(red, (1.0 - LUMINANCE.r * red - LUMINANCE.b * blue) / LUMINANCE.g, blue);
}

vec4 of_weave(int g, vec2 yarns) { return mix(vec4(yarns.x), vec4(yarns.y), slot_yarn[g]); }

// By how much threads differ from cloth from afar; its mean over the cloth is 0.
vec3 of_threads(ivec2 pixel, bool exact) {
    fetch_weave(pixel);
    vec2 at = (0.5 * vec2(pixel) + 0.5) / vec2(textureSize(terms, 0).xy);
    // Beside a pixel that has terms may be one that has none: not even with a weight of 0 are they read.
#define TERM(layer) (exact ? NEAREST(layer) : textureLod(terms, vec3(at, float(layer)), 0.0))
    // Colours vary even more slowly: the nearest will do.
#define NEAREST(layer) texelFetch(terms, ivec3(pixel >> 1, layer), 0)
    vec4 leans = NEAREST(7 * GROUPS);
    vec3 warp = vec3(leans.x, -(LUMINANCE.r * leans.x + LUMINANCE.b * leans.y) / LUMINANCE.g, leans.y);
    vec3 weft = vec3(leans.z, -(LUMINANCE.r * leans.z + LUMINANCE.b * leans.w) / LUMINANCE.g, leans.w);
    vec3 L = vec3(0.0);
#define ADD_SEEN(g) { \
    vec4 s = TERM(g), v = TERM(g + 3 * GROUPS), side = NEAREST(g + 6 * GROUPS); \
    mat3x4 color_s = with_green(NEAREST(g + GROUPS), NEAREST(g + 2 * GROUPS)); \
    mat3x4 color_v = with_green(NEAREST(g + 4 * GROUPS), NEAREST(g + 5 * GROUPS)); \
    vec4 strand_s = of_weave(g, strands.xz), strand_v = of_weave(g, strands.yw); \
    for (int c = 0; c < 3; ++c) { \
        vec4 seen = rel[g] + (side + of_weave(g, vec2(warp[c], weft[c]))) * turn[g]; \
        vec4 near_A = of_weave(g, vec2(pixel_A[0][c], pixel_A[1][c])), far_A = of_weave(g, vec2(weave_A[0][c], weave_A[1][c])); \
        L[c] += dot(s * color_s[c], seen * strand_s - 1.0) + dot(v * color_v[c], seen * strand_v * near_A - far_A); \
    } }
    EACH_GROUP(ADD_SEEN)
    return L / term_scale;
}
#endif

vec4 coarse_at(ivec2 p) {
    return texelFetch(coarse, clamp(p, ivec2(0), textureSize(coarse, 0) - 1), 0);
}

vec4 frame_at(ivec2 coarse_pixel) {
    return texelFetch(frame_N, min(2 * coarse_pixel, textureSize(frame_N, 0) - 1), 0);
}

// The value half way between `low` and low + d by the two before and the two behind it; alpha < 0: not to be trusted.
vec4 between(ivec2 low, ivec2 d, vec4 N) {
    vec4 a = coarse_at(low), b = coarse_at(low + d), before = coarse_at(low - d), after = coarse_at(low + 2 * d);
    // Beyond an edge of the cloth the curve goes on as it came.
    vec4 bend = before.a > 0.0 ? before - 2.0 * a + b : after.a > 0.0 ? a - 2.0 * b + after : vec4(0.0);
    if (before.a == 0.0) before = 2.0 * a - b + bend;
    if (after.a == 0.0) after = 2.0 * b - a + bend;
    vec4 bend_a = before - 2.0 * a + b, bend_b = a - 2.0 * b + after;
    vec4 middle = 0.5 * (a + b) - (bend_a + bend_b) / 16.0;
    float l_a = dot(a.rgb, LUMINANCE), l_b = dot(b.rgb, LUMINANCE);
    float B_a = dot(bend_a.rgb, LUMINANCE), B_b = dot(bend_b.rgb, LUMINANCE);
    // A curve bends alike at both; where a shadow's edge passes between they are opposite and as large as the step.
    float doubt = max(max(abs(B_a), abs(B_b)) / 16.0, abs(B_a - B_b) / 8.0);
    vec4 N_a = frame_at(low), N_b = frame_at(low + d);
    // The normal itself is known everywhere. Radiance follows it, so the normal's distance from its neighbours'
    // mean, in units of their difference, tells the share of the radiance's difference that interpolation misses.
    vec3 step_N = N_b.xyz - N_a.xyz, off = N.xyz - 0.5 * (N_a.xyz + N_b.xyz);
    float missed = abs(l_a - l_b) * length(off) / (length(step_N) + 1e-4);
    bool same = N_a.w == N.w && N_b.w == N.w;
    bool good = same && dot(step_N, step_N) < bend_limit * bend_limit && dot(off, off) < 0.04 * bend_limit * bend_limit
        && max(doubt, missed) <= tolerance * min(l_a, l_b);
    return vec4(max(middle.rgb, min(a.rgb, b.rgb) * 0.5), good ? a.a : -1.0);
}

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy), odd = pixel & 1, low = pixel >> 1;
    vec4 N = texelFetch(frame_N, pixel, 0);
    // Between two neighbours the line through them, between four both diagonals.
    bool diagonal = odd.x + odd.y == 2;
    vec4 first = between(low, odd, N);
    vec4 second = between(diagonal ? low + ivec2(0, 1) : low, diagonal ? ivec2(1, -1) : odd, N);
    bool exact = odd.x + odd.y == 0;
    vec4 mean = 0.5 * (first + second);
    float apart = abs(dot(first.rgb - second.rgb, LUMINANCE));
    bool good = min(first.a, second.a) > 0.0 && apart <= 4.0 * tolerance * dot(mean.rgb, LUMINANCE);
    color = exact ? coarse_at(low) : vec4(mean.rgb, first.a);
#ifdef WEAVE
    good = good && has_terms(low) && has_terms(low + odd) && has_terms(low + ivec2(odd.x, 0)) && has_terms(low + ivec2(0, odd.y));
    color.rgb = max(color.rgb + of_threads(pixel, exact), 0.0);
#endif
    if (!exact && !good) {
        uint i = atomicAdd(count, 1u);
        if ((i & 63u) == 0u) atomicAdd(groups.x, 1u);
        pixels[i] = uint(pixel.x) | uint(pixel.y) << 16;
    }
}
