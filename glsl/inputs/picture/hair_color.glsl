// The colour A of a hair of warp (0) or weft (1): that of the thread it grows from.
uniform vec3 weave_A[2];
uniform sampler2DArray color_map;  // see inputs/methods/weave.glsl
uniform bool colored;
uniform vec2 color_repeats;

vec3 hair_color(vec2 uv, int yarn) {
    if (!colored) return weave_A[yarn];
    vec4 here = textureLod(color_map, vec3(uv * color_repeats, float(yarn)), 0.0);
    vec4 wider = textureLod(color_map, vec3(uv * color_repeats, float(yarn)), 4.0);
    return here.a > 0.05 ? here.rgb / here.a : wider.a > 1e-3 ? wider.rgb / wider.a : weave_A[yarn];
}
