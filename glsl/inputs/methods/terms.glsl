// What each tangent adds to the radiance of a pixel, for a picture that combines them later with the maps of threads.   [own]
// Unlike what threads show, these terms vary from pixel to pixel as slowly as the radiance of cloth from afar.
// Stands for inputs/methods/threads.glsl. Every tangent keeps the colours of the light that it turns to: a lamp and the sky
// differ, and a yarn's two slopes see one each.
// Defines: TERMS; LANE_COUNT, tangents in each of GROUPS vec4s.
#define SUMS vec4
#define ADD_LIGHT(light, omega) add_light(light, omega)

// Red, green and blue (columns) of surface and volume terms, without the yarn's colour.
mat3x4 term_s[GROUPS], term_v[GROUPS];
vec4 term_side[GROUPS];  // luminance of what both add with it, times how far the light leans on the yarn,
mat3x2 side_sum;         // and red, green and blue of that, of all tangents of warp and of weft
mat3 lobe_terms;         // red, green and blue of surface and volume terms of the tangent whose lobe is visited,
float lobe_side;         // and luminance of what leans
// For tangents of negative, small and positive tilts: red, green and blue of surface and volume terms of warp and weft, and
// luminance of what leans on them; the weights of such tangents.
mat3x4 broad_terms[3];
vec2 broad_side[3];
vec4 broad_weight[3];

uniform float term_scale;  // of the terms that are kept, as half floats: a power of 2 that makes them about 1

const vec3 LIGHT_LUMINANCE = vec3(0.2126, 0.7152, 0.0722);

void begin_terms() {
#define NO_TERMS(g) { term_s[g] = term_v[g] = mat3x4(0.0); term_side[g] = vec4(0.0); }
    EACH_GROUP(NO_TERMS)
    side_sum = mat3x2(0.0);
    lobe_terms = mat3(0.0);
    lobe_side = 0.0;
}

vec4 color_of_yarn(int g, int channel) { return of_yarn(g, vec2(yarn_A[0][channel], yarn_A[1][channel])); }

// What surface and volume terms of warp and of weft reflect of the luminance of `light`.
vec2 luminance_of(vec3 light, vec4 sums) {
    vec3 weighed = LIGHT_LUMINANCE * light;
    return dot(weighed, vec3(1.0)) * sums.xz + vec2(dot(weighed, yarn_A[0]), dot(weighed, yarn_A[1])) * sums.yw;
}

void add_side(vec3 light, vec2 side, vec4 sums) {
    for (int c = 0; c < 3; ++c)
        side_sum[c] += light[c] * side * (sums.xz + vec2(yarn_A[0][c], yarn_A[1][c]) * sums.yw);
}

void add_light(vec3 light, vec3 omega) {
    vec2 side = lean(omega);
    // Luminance that leans, of a surface and of a volume term of 1.
    vec2 of_s = luminance_of(light, vec4(1.0, 0.0, 1.0, 0.0)) * side, of_v = luminance_of(light, vec4(0.0, 1.0, 0.0, 1.0)) * side;
    vec4 sums = vec4(0.0);
#define ADD_TERMS(g) { \
    vec4 s = surface[g] * slot_surface[g], v = volume[g] * (slot_volume_0[g] + slot_volume_1[g]); \
    term_s[g] += outerProduct(s, light); \
    term_v[g] += outerProduct(v, light); \
    term_side[g] += of_yarn(g, of_s) * s + of_yarn(g, of_v) * v; \
    vec2 all = vec2(dot(s, vec4(1.0)), dot(v, vec4(1.0))), of_weft = vec2(dot(s, slot_yarn[g]), dot(v, slot_yarn[g])); \
    sums += vec4(all - of_weft, of_weft); }
    EACH_GROUP(ADD_TERMS)
    add_side(light, side, sums);
}

void add_pooled(vec3 light, vec3 omega, vec4 weight) {
    vec2 side = lean(omega);
    // The tangent's other yarn has the weight 0.
    lobe_terms[0] += light * (weight.x + weight.z);
    lobe_terms[1] += light * (weight.y + weight.w);
    lobe_side += dot(side, luminance_of(light, weight));
    add_side(light, side, weight);
}

void end_lobe(int t) {
    vec4 lane = vec4(equal(ivec4(0, 1, 2, 3), ivec4(t % LANE_COUNT)));
    int group = t / LANE_COUNT;
#define ADD_LOBE(g) { vec4 mine = g == group ? lane : vec4(0.0); \
    term_s[g] += outerProduct(mine, lobe_terms[0]); \
    term_v[g] += outerProduct(mine, lobe_terms[1]); \
    term_side[g] += lobe_side * mine; }
    EACH_GROUP(ADD_LOBE)
    lobe_terms = mat3(0.0);
    lobe_side = 0.0;
}

// Broad light knows tangents of negative, small and positive tilts only: each has its share in those that are nearest to it.
mat3x4 broad_shares(int g) {
    vec4 low = slot_share[g] * slot_low[g], high = slot_share[g] * slot_high[g];
    return mat3x4(low, slot_share[g] - low - high, high);
}

vec4 yarn_sums(int g, vec4 weight) { return vec2(dot(weight, 1.0 - slot_yarn[g]), dot(weight, slot_yarn[g])).xxyy; }

void begin_broad() {
    for (int b = 0; b < 3; ++b) {
        broad_terms[b] = mat3x4(0.0);
        broad_weight[b] = vec4(0.0);
        broad_side[b] = vec2(0.0);
    }
#define WEIGH(g) { mat3x4 share = broad_shares(g); \
    for (int b = 0; b < 3; ++b) broad_weight[b] += yarn_sums(g, share[b]); }
    EACH_GROUP(WEIGH)
}

void add_broad(vec3 light, vec3 omega, vec4 low, vec4 middle, vec4 high) {
    vec2 side = lean(omega);
    broad_terms[0] += outerProduct(low, light);
    broad_terms[1] += outerProduct(middle, light);
    broad_terms[2] += outerProduct(high, light);
    broad_side[0] += side * luminance_of(light, low);
    broad_side[1] += side * luminance_of(light, middle);
    broad_side[2] += side * luminance_of(light, high);
    add_side(light, side, low * broad_weight[0] + middle * broad_weight[1] + high * broad_weight[2]);
}

void end_broad() {
#define SPREAD(g) { mat3x4 share = broad_shares(g); \
    for (int b = 0; b < 3; ++b) { \
        for (int c = 0; c < 3; ++c) { \
            term_s[g][c] += share[b] * of_yarn(g, broad_terms[b][c].xz); \
            term_v[g][c] += share[b] * of_yarn(g, broad_terms[b][c].yw); \
        } \
        term_side[g] += share[b] * of_yarn(g, broad_side[b]); \
    } }
    EACH_GROUP(SPREAD)
}

// The radiance of cloth from afar.
vec3 end_terms() {
    vec3 L = vec3(0.0);
#define ADD_ALL(g) L += vec4(1.0) * term_s[g] \
    + vec3(dot(color_of_yarn(g, 0), term_v[g][0]), dot(color_of_yarn(g, 1), term_v[g][1]), dot(color_of_yarn(g, 2), term_v[g][2]));
    EACH_GROUP(ADD_ALL)
    return L;
}

// A term's luminance, scaled, and its red and blue for a luminance of 1.
mat3x4 term_texels(mat3x4 term) {
    vec4 luminance = term * LIGHT_LUMINANCE, one = 1.0 / max(luminance, 1e-20);
    return mat3x4(term_scale * luminance, term[0] * one, term[2] * one);
}

// What both terms of each tangent add, in luminance.
vec4 luminance_terms(int g) {
    vec4 all = term_s[g] * LIGHT_LUMINANCE;
    for (int c = 0; c < 3; ++c) all += LIGHT_LUMINANCE[c] * color_of_yarn(g, c) * term_v[g][c];
    return all;
}

// How far the light of each tangent leans on its yarn,
vec4 side_texel(int g) { return term_side[g] / max(luminance_terms(g), 1e-20); }

// and how much farther its red and blue do on warp and on weft, in the mean: (red, blue) of warp, of weft.
vec4 side_color_texel() {
    mat3x2 all = mat3x2(0.0);
#define ADD_YARN(g) { mat2x4 yarn = mat2x4(1.0 - slot_yarn[g], slot_yarn[g]); \
    for (int c = 0; c < 3; ++c) all[c] += (term_s[g][c] + color_of_yarn(g, c) * term_v[g][c]) * yarn; }
    EACH_GROUP(ADD_YARN)
    vec2 mean = (side_sum * LIGHT_LUMINANCE) / max(all * LIGHT_LUMINANCE, 1e-20);
    return vec4(side_sum[0] / max(all[0], 1e-20) - mean, side_sum[2] / max(all[2], 1e-20) - mean).xzyw;
}
