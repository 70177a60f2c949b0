// How much of each tangent a ray sees where it meets cloth, and in which colours.   [own]
// Stands for inputs/methods/threads.glsl in the tracer, where rays are fine enough to see threads.
// Defines: WEAVE, GROUPS, LANE_COUNT. See glcloth/tracing/threads.py.
#include "inputs/methods/rel.glsl"
uniform sampler2DArray weave_map;  // GROUPS layers of rel, then of turn
uniform sampler2DArray color_map;  // of warp and of weft: colour times share, share
#ifdef FABRICS
// Each fabric has its own, one behind the other; take_fabric says which one counts.
#include "inputs/tracing/fabrics.glsl"
uniform vec4 thread_of[FABRICS];  // weave_repeats of one fabric, its first layer, its layers of rel
uniform vec4 color_of[FABRICS];   // color_repeats, the first layer, colored
uniform vec3 weave_A[2 * FABRICS];
uniform vec4 tangent_shares[GROUPS * FABRICS];
#define weave_repeats thread_of[fabric_number].xy
// A fabric with fewer tangents than another has no more layers than it needs; nobody asks for tangents that it lacks.
#define REL_LAYER(g) (thread_of[fabric_number].z + min(float(g), thread_of[fabric_number].w - 1.0))
#define TURN_LAYER(g) (REL_LAYER(g) + thread_of[fabric_number].w)
#define color_repeats color_of[fabric_number].xy
#define COLOR_LAYER(j) (color_of[fabric_number].z + float(j))
#define colored (color_of[fabric_number].w > 0.0)
#define OF_FABRIC(i, n) (i + n * fabric_number)
#else
uniform vec2 weave_repeats;        // 1/m, along u and v
uniform bool colored;              // whether threads have colours of their own
uniform vec2 color_repeats;        // 1/m
uniform vec3 weave_A[2];
uniform vec4 tangent_shares[GROUPS];  // of each tangent, of all yarns
#define REL_LAYER(g) float(g)
#define TURN_LAYER(g) float(g + GROUPS)
#define COLOR_LAYER(j) float(j)
#define OF_FABRIC(i, n) i
#endif
vec3 place_A[2];
#define COLORED(sums) ((sums).x + place_A[0] * (sums).y + (sums).z + place_A[1] * (sums).w)

// Take the place uv, metres, of which a pixel covers `width` metres, and shows so much threads. Returns how much of the cloth
// there is, and how light it lies, over the mean.
float fetch_threads(vec2 uv, float width, float shown) {
    vec2 texels = width * weave_repeats * vec2(textureSize(weave_map, 0).xy);
    float level = log2(max(max(texels.x, texels.y), 1.0)), cover = 0.0;
    for (int g = 0; g < GROUPS; ++g) {
        rel[g] = mix(vec4(1.0), textureLod(weave_map, vec3(uv * weave_repeats, REL_LAYER(g)), level), shown);
        turn[g] = shown * textureLod(weave_map, vec3(uv * weave_repeats, TURN_LAYER(g)), level);
        cover += dot(rel[g], tangent_shares[OF_FABRIC(g, GROUPS)]);
    }
    place_A[0] = weave_A[OF_FABRIC(0, 2)];
    place_A[1] = weave_A[OF_FABRIC(1, 2)];
    if (!colored) return cover;
    texels = width * color_repeats * vec2(textureSize(color_map, 0).xy);
    level = log2(max(max(texels.x, texels.y), 1.0));
    for (int j = 0; j < 2; ++j) {
        vec4 color = textureLod(color_map, vec3(uv * color_repeats, COLOR_LAYER(j)), level);
        if (color.a > 1e-4) place_A[j] = mix(weave_A[OF_FABRIC(j, 2)], color.rgb / color.a, shown);
    }
    return cover;
}
