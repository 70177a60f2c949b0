// The fabrics of all cloths of the path tracer: their reflectance, exactly, and directions drawn from its lobes.
// glcloth/tracing/path.py fills the buffers: of each cloth (tangents of yarn 0, of yarn 1, sigma_mask, gap), (rho, k_a, k_t,
// diffuse), (tau, the triangle behind its last), (eta_1, eta_2, factor of the reflectance, 1 if it lets light through), (albedo, first row of its mask; -1: none),
// (roughness, roughness_p, the pictures of the print and of the opacity), (how often both repeat in a UV unit), (the
// mask's size, how often it repeats); a cloth with a mask has such records for each of its fabrics, one after the other;
// and the records of inputs/picture/fabric.glsl, FABRIC_TEXELS a cloth.
#include "core/shared.glsl"
#include "fibre/frame.glsl"
#include "fibre/lobe.glsl"
#include "fibre/tangent.glsl"
#include "trace/random.glsl"
#include "inputs/tracing/path_surface.glsl"
#ifdef WEAVE
#include "inputs/tracing/path_threads.glsl"
#endif
uniform samplerBuffer fabric_data;

const int FABRIC_TEXELS = 4 + MAX_TANGENTS;
const float COSINE_SHARE = 0.2;  // of the directions, for what is even in the fabric

struct Fabric {
    int first;        // its texel in fabric_data
    ivec2 tangents;
    float sigma;
    float gap;
    float limit;
    vec3 tint;        // of the yarns' colours
};

Fabric fetch_fabric(int cloth) {
    vec4 p = texelFetch(cloth_data, CLOTH_TEXELS * cloth);
    return Fabric(FABRIC_TEXELS * cloth, ivec2(p.xy), p.z, p.w, texelFetch(cloth_data, CLOTH_TEXELS * cloth + 3).z,
        vec3(1.0));
}

// One tangent with its yarn.
struct Thread {
    int yarn;
    vec3 A;
    float eta;
    float k_d;
    float gamma_s;
    float gamma_v;
    Tangent tangent;
};

Thread fetch_thread(Fabric fabric, int t) {
    int j = t < fabric.tangents.x ? 0 : 1;
    vec4 p = texelFetch(fabric_data, fabric.first + 2 * j), q = texelFetch(fabric_data, fabric.first + 2 * j + 1);
    vec4 r = texelFetch(fabric_data, fabric.first + 4 + t);
    vec3 A = fabric.tint * p.xyz;
#ifdef WEAVE
    if (at_threads) A = j == 0 ? pixel_A[0] : pixel_A[1];
#endif
    return Thread(j, A, p.w, q.x, q.y, q.z, Tangent(r.x, r.y, r.z, r.w));
}

float luminance(vec3 color) { return dot(color, vec3(0.2126, 0.7152, 0.0722)); }

// Weights of the two lobes of a thread, and where they end.
vec2 weights_of(Thread thread, vec3 o, out vec2 ends_v, out vec2 ends_s) {
    ends_v = lobe_ends(o, thread.gamma_v);
    ends_s = lobe_ends(o, thread.gamma_s);
    return lobe_weights(o, thread.tangent.weight, luminance(thread.A), thread.eta, thread.k_d, ends_v, ends_s);
}

// Radiance toward omega_o per unit irradiance (perpendicular to the light) from omega_i, as f_cloth of
// inputs/picture/fabric.glsl; and the density with which `drawn_direction` draws omega_i.
vec3 f_and_pdf(Fabric fabric, vec3 omega_i, vec3 omega_o, out float pdf) {
    bool lit = min(omega_i.z, omega_o.z) > 0.0;
    float Q = fabric.gap * omega_o.z, all = 0.0, dense = 0.0;
    vec3 sum = vec3(0.0);
    int last = lit ? fabric.tangents.x + fabric.tangents.y : 1;
    int t = 0;
    do {
        Thread thread = fetch_thread(fabric, t);
        vec3 i = tangent_from_surface(omega_i, thread.yarn, thread.tangent.cos_tilt, thread.tangent.sin_tilt);
        vec3 o = tangent_from_surface(omega_o, thread.yarn, thread.tangent.cos_tilt, thread.tangent.sin_tilt);
        vec3 terms = tangent_terms(i, o, thread.tangent.weight, thread.eta, thread.k_d, thread.gamma_s, thread.gamma_v,
            fabric.sigma);
        Q += thread.tangent.share * terms.x;
#ifdef WEAVE
        vec2 seen = seen_tangent(t);
        terms.yz *= seen_of(seen, thread.yarn, omega_i) * (thread.yarn == 0 ? strands.xy : strands.zw);
#endif
        sum += terms.y + thread.A * terms.z;
        vec2 ends_v, ends_s;
        vec2 weights = weights_of(thread, o, ends_v, ends_s);
#ifdef WEAVE
        weights *= seen.x;
#endif
        all += weights.x + weights.y;
        dense += weights.x * lobe_pdf(i, o, thread.gamma_v, ends_v, 0) + weights.y * lobe_pdf(i, o, thread.gamma_s, ends_s, 1);
        ++t;
    } while (t < last);
    float cosine = max(omega_i.z, 0.0) / PI;
    pdf = lit ? all > 0.0 ? mix(dense / all, cosine, COSINE_SHARE) : cosine : 0.0;
    return lit && Q > 0.0 ? fabric.limit * sum / Q : vec3(0.0);
}

// A direction of a lobe, or as the cosine: by a number from 0 to 1 that chooses, and two that place it. It may lie below the
// horizon: such a draw brings nothing.
vec3 drawn_direction(Fabric fabric, vec3 omega_o, float choice, vec2 u) {
    float lobes = (choice - COSINE_SHARE) / (1.0 - COSINE_SHARE);
    float all = 0.0;
    vec3 chosen_o = vec3(0.0, 0.0, 1.0);
    vec2 chosen_ends = vec2(-1.0, 1.0);
    float chosen_gamma = 1.0;
    int chosen_lobe = -1;
    Tangent chosen_tangent;
    int chosen_yarn = 0;
    int t = 0;
    // Each lobe takes the place of the one chosen before with its share of the sum so far; the number is stretched anew.
    do {
        Thread thread = fetch_thread(fabric, t);
        vec3 o = tangent_from_surface(omega_o, thread.yarn, thread.tangent.cos_tilt, thread.tangent.sin_tilt);
        vec2 ends_v, ends_s;
        vec2 weights = weights_of(thread, o, ends_v, ends_s);
#ifdef WEAVE
        weights *= seen_tangent(t).x;
#endif
        float both = weights.x + weights.y;
        all += both;
        float share = all > 0.0 ? both / all : 0.0;
        bool taken = lobes >= 0.0 && lobes < share;
        float within = taken ? lobes / max(share, 1e-30) : 0.0;
        lobes = lobes < 0.0 ? lobes : taken ? within : (lobes - share) / max(1.0 - share, 1e-30);
        float of_surface = weights.y / max(both, 1e-30);
        bool surface = taken && lobes < of_surface;
        if (taken) {
            lobes = surface ? lobes / max(of_surface, 1e-30) : (lobes - of_surface) / max(1.0 - of_surface, 1e-30);
            chosen_o = o;
            chosen_ends = surface ? ends_s : ends_v;
            chosen_gamma = surface ? thread.gamma_s : thread.gamma_v;
            chosen_lobe = surface ? 1 : 0;
            chosen_tangent = thread.tangent;
            chosen_yarn = thread.yarn;
        }
        ++t;
    } while (t < fabric.tangents.x + fabric.tangents.y);
    if (chosen_lobe < 0) return cosine_direction(u);
    vec3 k = lobe_direction(chosen_o, chosen_gamma, chosen_ends, chosen_lobe, u);
    float along = k.x * chosen_tangent.cos_tilt + k.z * chosen_tangent.sin_tilt;
    float up = k.z * chosen_tangent.cos_tilt - k.x * chosen_tangent.sin_tilt;
    return chosen_yarn == 0 ? vec3(along, k.y, up) : vec3(-k.y, along, up);
}
