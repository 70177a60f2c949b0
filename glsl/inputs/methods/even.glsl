// What a pixel of woven or printed cloth reflects of light that comes from all around, over what the whole cloth does.   [own]
// Its mean over the cloth is 1, as that of each rel is: bounced light keeps its mean, and shows threads, colours and prints too.
// Needs rel, strands, weave_A and pixel_A of the file that includes it.
uniform vec4 even_warp[GROUPS];  // shares of the tangents of each yarn in that reflection, without its colour; all: 1
uniform vec4 even_weft[GROUPS];

vec3 seen_evenly() {
    vec2 near = vec2(0.0), far = vec2(0.0);
#define ADD_EVEN(g) { \
    near += vec2(dot(rel[g], even_warp[g]), dot(rel[g], even_weft[g])); \
    far += vec2(dot(vec4(1.0), even_warp[g]), dot(vec4(1.0), even_weft[g])); }
    EACH_GROUP(ADD_EVEN)
    near *= strands.yw;
    vec3 whole = far.x * weave_A[0] + far.y * weave_A[1];
    return (near.x * pixel_A[0] + near.y * pixel_A[1] + 1e-6) / (whole + 1e-6);
}
