// The colour A of a hair of warp (0) or weft (1): that of the thread it grows from.
#include "inputs/methods/levels.glsl"
uniform vec3 weave_A[2];
uniform bool colored;

vec3 hair_color(vec2 uv, int yarn) {
    if (!colored) return weave_A[yarn];
    vec4 here = color_at(0.0, uv * color_repeats, yarn);
    vec4 wider = color_at(level_number(4.0, color_steps, 0.0).x, uv * color_repeats, yarn);
    return here.a > 0.05 ? here.rgb / here.a : wider.a > 1e-3 ? wider.rgb / wider.a : weave_A[yarn];
}
