// How much of each tangent a ray sees where it meets cloth, and in which colours.   [own]
// Stands for inputs/methods/threads.glsl in the tracer, where rays are fine enough to see threads.
// Defines: WEAVE, GROUPS, LANE_COUNT. See glcloth/tracing/threads.py.
#include "inputs/methods/rel.glsl"
uniform sampler2DArray weave_map;  // GROUPS layers of rel, then of turn
uniform vec2 weave_repeats;        // 1/m, along u and v
uniform sampler2DArray color_map;  // of warp and of weft: colour times share, share
uniform bool colored;              // whether threads have colours of their own
uniform vec2 color_repeats;        // 1/m
uniform vec3 weave_A[2];
uniform vec4 tangent_shares[GROUPS];  // of each tangent, of all yarns
vec3 place_A[2];
#define COLORED(sums) ((sums).x + place_A[0] * (sums).y + (sums).z + place_A[1] * (sums).w)

// Take the place uv, metres, of which a pixel covers `width` metres, and shows so much threads. Returns how much of the cloth
// there is, and how light it lies, over the mean.
float fetch_threads(vec2 uv, float width, float shown) {
    vec2 texels = width * weave_repeats * vec2(textureSize(weave_map, 0).xy);
    float level = log2(max(max(texels.x, texels.y), 1.0)), cover = 0.0;
    for (int g = 0; g < GROUPS; ++g) {
        rel[g] = mix(vec4(1.0), textureLod(weave_map, vec3(uv * weave_repeats, float(g)), level), shown);
        turn[g] = shown * textureLod(weave_map, vec3(uv * weave_repeats, float(g + GROUPS)), level);
        cover += dot(rel[g], tangent_shares[g]);
    }
    place_A[0] = weave_A[0];
    place_A[1] = weave_A[1];
    if (!colored) return cover;
    texels = width * color_repeats * vec2(textureSize(color_map, 0).xy);
    level = log2(max(max(texels.x, texels.y), 1.0));
    for (int j = 0; j < 2; ++j) {
        vec4 color = textureLod(color_map, vec3(uv * color_repeats, float(j)), level);
        if (color.a > 1e-4) place_A[j] = mix(weave_A[j], color.rgb / color.a, shown);
    }
    return cover;
}
