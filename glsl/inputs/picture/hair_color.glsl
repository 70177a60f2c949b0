// The colour A of a hair of warp (0) or weft (1): that of the thread it grows from, printed where the cloth is.
// Define: PRINT, where there is a print (inputs/picture/print.glsl).
#include "inputs/methods/levels.glsl"
uniform vec3 weave_A[2];
uniform bool colored;

#ifdef PRINT
uniform sampler2DArray print_map;
uniform vec3 print_mean;
uniform vec2 print_repeats;
#endif

vec3 thread_color(vec2 uv, int yarn) {
    if (!colored) return weave_A[yarn];
    vec4 here = color_at(0.0, uv * color_repeats, yarn);
    vec4 wider = color_at(level_number(4.0, color_steps, 0.0).x, uv * color_repeats, yarn);
    bool own = here.a > 0.05 || wider.a > 1e-3;
    vec3 A = here.a > 0.05 ? here.rgb / here.a : own ? wider.rgb / wider.a : weave_A[yarn];
#ifdef PRINT
    // The map of threads' colours is not dyed in the mean of the print, as `weave_A` is.
    if (own) A *= print_mean;
#endif
    return A;
}

vec3 hair_color(vec2 uv, int yarn) {
    vec3 A = thread_color(uv, yarn);
#ifdef PRINT
    A *= textureLod(print_map, vec3(uv * print_repeats, 0.0), 0.0).rgb;
#endif
    return A;
}
