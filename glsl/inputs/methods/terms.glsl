// What each tangent adds to the radiance of a pixel, for a picture that combines them later with the maps of threads.   [own]
// Unlike what threads show, these terms vary from pixel to pixel as slowly as the radiance of cloth from afar.
// Stands for inputs/methods/threads.glsl. A term is a number, in luminance of light, times the colour of light that its yarn's
// surface or volume terms have in common: what they add up to is exact.
// Defines: TERMS; LANE_COUNT, tangents in each of GROUPS vec4s.
#define SUMS vec4
#define ADD_LIGHT(light, omega) add_light(light, omega)

const vec3 LIGHT_LUMINANCE = vec3(0.2126, 0.7152, 0.0722);
vec4 term_s[GROUPS], term_v[GROUPS];  // surface and volume terms
vec4 term_side[GROUPS];  // what they add, times how far the light leans on the yarn
mat4x3 term_light;       // sums of these times light's colour: surface, volume of warp, of weft
vec2 luminance_A;        // of the yarns
vec3 lobe_terms;         // of the tangent whose lobe is visited
// For tangents of negative, small and positive tilts: sums, and those that lean on warp and weft; the weights of such tangents.
vec4 broad_terms[3], broad_weight[3];
vec2 broad_side[3];

void begin_terms() {
#define NO_TERMS(g) term_s[g] = term_v[g] = term_side[g] = vec4(0.0);
    EACH_GROUP(NO_TERMS)
    term_light = mat4x3(0.0);
    luminance_A = vec2(dot(yarn_A[0], LIGHT_LUMINANCE), dot(yarn_A[1], LIGHT_LUMINANCE));
    lobe_terms = vec3(0.0);
}

// What the yarns make of surface and volume terms of warp and of weft.
vec2 reflected(vec4 sums) { return sums.xz + sums.yw * luminance_A; }

void add_light(vec3 light, vec3 omega) {
    float luminance = dot(light, LIGHT_LUMINANCE);
    vec2 side = lean(omega);
    vec4 sums = vec4(0.0);
#define ADD_TERMS(g) { \
    vec4 s = luminance * surface[g] * slot_surface[g], v = luminance * volume[g] * (slot_volume_0[g] + slot_volume_1[g]); \
    term_s[g] += s; \
    term_v[g] += v; \
    term_side[g] += of_yarn(g, side) * (s + of_yarn(g, luminance_A) * v); \
    vec2 all = vec2(dot(s, vec4(1.0)), dot(v, vec4(1.0))), of_weft = vec2(dot(s, slot_yarn[g]), dot(v, slot_yarn[g])); \
    sums += vec4(all - of_weft, of_weft); }
    EACH_GROUP(ADD_TERMS)
    term_light += outerProduct(light / max(luminance, 1e-20), sums);
}

void add_pooled(vec3 light, vec3 omega, vec4 weight) {
    float luminance = dot(light, LIGHT_LUMINANCE);
    term_light += outerProduct(light, weight);
    // The tangent's other yarn has the weight 0.
    lobe_terms += luminance * vec3(weight.xy + weight.zw, dot(lean(omega), reflected(weight)));
}

void end_lobe(int t) {
    vec4 lane = vec4(equal(ivec4(0, 1, 2, 3), ivec4(t % LANE_COUNT)));
    int group = t / LANE_COUNT;
#define ADD_LOBE(g) { vec4 mine = g == group ? lane : vec4(0.0); \
    term_s[g] += lobe_terms.x * mine; \
    term_v[g] += lobe_terms.y * mine; \
    term_side[g] += lobe_terms.z * mine; }
    EACH_GROUP(ADD_LOBE)
    lobe_terms = vec3(0.0);
}

// Broad light knows tangents of negative, small and positive tilts only: each has its share in those that are nearest to it.
mat3x4 broad_shares(int g) {
    vec4 low = slot_share[g] * slot_low[g], high = slot_share[g] * slot_high[g];
    return mat3x4(low, slot_share[g] - low - high, high);
}

vec4 yarn_sums(int g, vec4 weight) { return vec2(dot(weight, 1.0 - slot_yarn[g]), dot(weight, slot_yarn[g])).xxyy; }

void begin_broad() {
    for (int b = 0; b < 3; ++b) {
        broad_terms[b] = broad_weight[b] = vec4(0.0);
        broad_side[b] = vec2(0.0);
    }
#define WEIGH(g) { mat3x4 share = broad_shares(g); \
    broad_weight[0] += yarn_sums(g, share[0]); \
    broad_weight[1] += yarn_sums(g, share[1]); \
    broad_weight[2] += yarn_sums(g, share[2]); }
    EACH_GROUP(WEIGH)
}

void add_broad(vec3 light, vec3 omega, vec4 low, vec4 middle, vec4 high) {
    float luminance = dot(light, LIGHT_LUMINANCE);
    vec2 side = luminance * lean(omega);
    broad_terms[0] += luminance * low;
    broad_terms[1] += luminance * middle;
    broad_terms[2] += luminance * high;
    broad_side[0] += side * reflected(low);
    broad_side[1] += side * reflected(middle);
    broad_side[2] += side * reflected(high);
    term_light += outerProduct(light, low * broad_weight[0] + middle * broad_weight[1] + high * broad_weight[2]);
}

void end_broad() {
#define SPREAD(g) { mat3x4 share = broad_shares(g); \
    for (int b = 0; b < 3; ++b) { \
        term_s[g] += share[b] * of_yarn(g, broad_terms[b].xz); \
        term_v[g] += share[b] * of_yarn(g, broad_terms[b].yw); \
        term_side[g] += share[b] * of_yarn(g, broad_side[b]); \
    } }
    EACH_GROUP(SPREAD)
}

// The radiance of cloth from afar.
vec3 end_terms() {
    return term_light[0] + yarn_A[0] * term_light[1] + term_light[2] + yarn_A[1] * term_light[3];
}

// How far the light of each tangent leans on its yarn.
vec4 side_texel(int g) { return term_side[g] / max(term_s[g] + of_yarn(g, luminance_A) * term_v[g], 1e-20); }

// The light's colours, of surface and volume terms of warp and of weft, in three texels.
mat3x4 light_texels() {
    vec4 one = 1.0 / max(LIGHT_LUMINANCE * term_light, 1e-20);
    return transpose(mat4x3(term_light[0] * one.x, term_light[1] * one.y, term_light[2] * one.z, term_light[3] * one.w));
}
