#version 430
// Fills the picture from every second pixel of every second row, and lists the pixels where that is not good enough.   [own]
#include "inputs/picture/adaptive.glsl"
layout(early_fragment_tests) in;  // a shader that writes to a buffer is tested late otherwise
layout(std430) buffer Pixels {
    uvec3 groups;  // of 64 pixels, for the dispatch of passes/picture/shade_list.comp
    uint count;
    uint pixels[];  // x + 65536 y
};
out vec4 color;

#ifdef WEAVE
// Where pixels show threads: what each tangent adds varies as slowly as cloth from afar, so it is that which is interpolated.
#include "inputs/methods/threads.glsl"  // that is weave.glsl or printed.glsl
uniform sampler2DArray terms;  // of inputs/picture/shade_terms.glsl
uniform int wide_row;          // its row in which terms of every fourth pixel of every fourth row begin
uniform sampler2D smooth_blocks;  // of passes/picture/adaptive_blocks.frag
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
vec3 of_threads(ivec2 pixel) {
    fetch_weave(pixel);
    // In smooth blocks of 4 x 4 pixels only their corners have terms, behind the others. One choice of a place instead of a
    // choice between fetches: a software rasteriser makes all that either side of a branch asks for.
    bool smooth_here = texelFetch(smooth_blocks, pixel >> 2, 0).r > 0.5;
    ivec2 nearest = smooth_here ? ((pixel + 2) >> 2) + ivec2(0, wide_row) : pixel >> 1;
    vec2 at = (smooth_here ? 0.25 * vec2(pixel) + vec2(0.5, 0.5 + float(wide_row)) : 0.5 * vec2(pixel) + 0.5) / vec2(textureSize(terms, 0).xy);
#define TERM(layer) textureLod(terms, vec3(at, float(layer)), 0.0)
    // Colours vary even more slowly: the nearest will do.
#define NEAREST(layer) texelFetch(terms, ivec3(nearest, layer), 0)
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
    L += TERM(7 * GROUPS + 1).rgb * (seen_evenly() - 1.0);
    return L / term_scale;
}
#endif

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy), odd = pixel & 1, low = pixel >> 1;
    vec4 N = texelFetch(frame_N, pixel, 0);
    bool exact = odd.x + odd.y == 0;
    vec4 mean = interpolated(low, odd, N);
    bool good = mean.a > 0.0;
    color = exact ? coarse_at(low) : mean;
#ifdef WEAVE
    good = good && has_terms(low) && has_terms(low + odd) && has_terms(low + ivec2(odd.x, 0)) && has_terms(low + ivec2(0, odd.y));
    color.rgb = max(color.rgb + of_threads(pixel), 0.0);
#endif
    if (!exact && !good) {
        uint i = atomicAdd(count, 1u);
        if ((i & 63u) == 0u) atomicAdd(groups.x, 1u);
        pixels[i] = uint(pixel.x) | uint(pixel.y) << 16;
    }
}
