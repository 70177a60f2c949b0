// What each tangent adds to the radiance of a pixel, for a picture that combines them later with the maps of threads.   [own]
// Unlike what threads show, these terms vary from pixel to pixel as slowly as the radiance of cloth from afar.
// Stands for inputs/methods/threads.glsl. Every tangent keeps the colours of the light that it turns to: a lamp and the sky
// differ, and a yarn's two slopes see one each.
// Defines: TERMS; LANE_COUNT, tangents in each of GROUPS vec4s.
#define SUMS vec4
#define ADD_LIGHT(light, omega) add_light(light, omega)

// Red, green and blue (columns) of surface and volume terms, without the yarn's colour; and with it what both add, times how
// far the light leans on the yarn.
mat3x4 term_s[GROUPS], term_v[GROUPS], term_side[GROUPS];
mat3 lobe_terms;  // surface and volume terms and what leans, of the tangent whose lobe is visited
// For tangents of negative, small and positive tilts: red, green and blue of surface and volume terms of warp and weft, and of
// what leans on them.
mat3x4 broad_terms[3];
mat3x2 broad_side[3];

void begin_terms() {
#define NO_TERMS(g) term_s[g] = term_v[g] = term_side[g] = mat3x4(0.0);
    EACH_GROUP(NO_TERMS)
    lobe_terms = mat3(0.0);
}

vec4 color_of_yarn(int g, int channel) { return of_yarn(g, vec2(yarn_A[0][channel], yarn_A[1][channel])); }

void add_light(vec3 light, vec3 omega) {
    vec2 side = lean(omega);
#define ADD_TERMS(g) { \
    vec4 s = surface[g] * slot_surface[g], v = volume[g] * (slot_volume_0[g] + slot_volume_1[g]), leans = of_yarn(g, side); \
    term_s[g] += outerProduct(s, light); \
    term_v[g] += outerProduct(v, light); \
    s *= leans; \
    v *= leans; \
    term_side[g] += mat3x4(light[0] * (s + color_of_yarn(g, 0) * v), light[1] * (s + color_of_yarn(g, 1) * v), \
        light[2] * (s + color_of_yarn(g, 2) * v)); }
    EACH_GROUP(ADD_TERMS)
}

void add_pooled(vec3 light, vec3 omega, vec4 weight) {
    // The tangent's other yarn has the weight 0.
    vec2 side = lean(omega);
    vec3 leans = side.x * (weight.x + weight.y * yarn_A[0]) + side.y * (weight.z + weight.w * yarn_A[1]);
    lobe_terms += mat3(light * (weight.x + weight.z), light * (weight.y + weight.w), light * leans);
}

void end_lobe(int t) {
    vec4 lane = vec4(equal(ivec4(0, 1, 2, 3), ivec4(t % LANE_COUNT)));
    int group = t / LANE_COUNT;
#define ADD_LOBE(g) { vec4 mine = g == group ? lane : vec4(0.0); \
    term_s[g] += outerProduct(mine, lobe_terms[0]); \
    term_v[g] += outerProduct(mine, lobe_terms[1]); \
    term_side[g] += outerProduct(mine, lobe_terms[2]); }
    EACH_GROUP(ADD_LOBE)
    lobe_terms = mat3(0.0);
}

// Broad light knows tangents of negative, small and positive tilts only: each has its share in those that are nearest to it.
mat3x4 broad_shares(int g) {
    vec4 low = slot_share[g] * slot_low[g], high = slot_share[g] * slot_high[g];
    return mat3x4(low, slot_share[g] - low - high, high);
}

void begin_broad() {
    for (int b = 0; b < 3; ++b) {
        broad_terms[b] = mat3x4(0.0);
        broad_side[b] = mat3x2(0.0);
    }
}

void add_bin(int b, vec3 light, vec2 side, vec4 sums) {
    broad_terms[b] += outerProduct(sums, light);
    vec3 warp = light * (sums.x + sums.y * yarn_A[0]), weft = light * (sums.z + sums.w * yarn_A[1]);
    broad_side[b] += transpose(mat2x3(side.x * warp, side.y * weft));
}

void add_broad(vec3 light, vec3 omega, vec4 low, vec4 middle, vec4 high) {
    vec2 side = lean(omega);
    add_bin(0, light, side, low);
    add_bin(1, light, side, middle);
    add_bin(2, light, side, high);
}

void end_broad() {
#define SPREAD(g) { mat3x4 share = broad_shares(g); \
    for (int b = 0; b < 3; ++b) for (int c = 0; c < 3; ++c) { \
        term_s[g][c] += share[b] * of_yarn(g, broad_terms[b][c].xz); \
        term_v[g][c] += share[b] * of_yarn(g, broad_terms[b][c].yw); \
        term_side[g][c] += share[b] * of_yarn(g, broad_side[b][c]); \
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

const vec3 LIGHT_LUMINANCE = vec3(0.2126, 0.7152, 0.0722);

// A term's luminance, and its red and blue for a luminance of 1.
mat3x4 term_texels(mat3x4 term) {
    vec4 luminance = term * LIGHT_LUMINANCE, one = 1.0 / max(luminance, 1e-20);
    return mat3x4(luminance, term[0] * one, term[2] * one);
}

// What both terms of each tangent add, in luminance.
vec4 luminance_terms(int g) {
    vec4 all = term_s[g] * LIGHT_LUMINANCE;
    for (int c = 0; c < 3; ++c) all += LIGHT_LUMINANCE[c] * color_of_yarn(g, c) * term_v[g][c];
    return all;
}

// How far the light of each tangent leans on its yarn,
vec4 side_texel(int g) { return term_side[g] * LIGHT_LUMINANCE / max(luminance_terms(g), 1e-20); }

// and how much farther its red and blue do on warp and on weft, in the mean: (red, blue) of warp, of weft.
vec4 side_color_texel() {
    mat3x2 all = mat3x2(0.0), leans = mat3x2(0.0);  // red, blue, luminance of warp and weft
#define ADD_SIDE(g) { \
    mat2x4 yarn = mat2x4(1.0 - slot_yarn[g], slot_yarn[g]); \
    for (int c = 0; c < 3; c += 2) { \
        all[c / 2] += (term_s[g][c] + color_of_yarn(g, c) * term_v[g][c]) * yarn; \
        leans[c / 2] += term_side[g][c] * yarn; \
    } \
    all[2] += luminance_terms(g) * yarn; \
    leans[2] += term_side[g] * LIGHT_LUMINANCE * yarn; }
    EACH_GROUP(ADD_SIDE)
    mat3x2 side;
    for (int c = 0; c < 3; ++c) side[c] = leans[c] / max(all[c], 1e-20);
    return vec4(side[0] - side[2], side[1] - side[2]).xzyw;
}
