// The fabric of a draw: its buffer, and its reflectance summed over all tangents, exactly.   [Miz 5-6]
// glcloth/gpu/scene_buffers.py fills the buffer: two Yarns, then the Tangents of yarn 0 and of yarn 1.
#include "core/shared.glsl"
#include "fibre/frame.glsl"
#include "fibre/tangent.glsl"
#include "inputs/methods/rel.glsl"
#include "inputs/methods/threads.glsl"

uniform samplerBuffer fabric_data;
#ifdef FABRICS
#include "inputs/tracing/fabrics.glsl"
#else
uniform ivec2 tangent_count;  // of yarn 0 and of yarn 1
uniform float sigma_mask;     // width of shadowing and masking, radians
uniform float gap;            // 1 - a_1 - a_2 in W's normaliser
const int fabric_first = 0;
#endif

Yarn fetch_yarn(int j) {
    vec4 p = texelFetch(fabric_data, fabric_first + 2 * j);
    vec4 q = texelFetch(fabric_data, fabric_first + 2 * j + 1);
    return Yarn(p.xyz, p.w, q.x, q.y, q.z, q.w);
}

Tangent fetch_tangent(int t) {
    vec4 p = texelFetch(fabric_data, fabric_first + 4 + t);
    return Tangent(p.x, p.y, p.z, p.w);
}

// [Miz 5-6, errata E7, E8]  sum_t w_t W_t (f_rs + A f_rv) cos(theta_i): radiance toward omega_o per unit irradiance
// (perpendicular to the light) from omega_i; both in the surface frame. Twin: glcloth/twins/cloth.py f_cloth
vec3 f_cloth(vec3 omega_i, vec3 omega_o) {
    bool lit = min(omega_i.z, omega_o.z) > 0.0;
    Yarn warp = fetch_yarn(0);
    Yarn weft = fetch_yarn(1);
    float Q = gap * omega_o.z;
    vec2 terms_1 = vec2(0.0);
    vec2 terms_2 = vec2(0.0);
    // A software rasteriser executes every branch; a loop that stops after one round is the way not to.
    int last = lit ? tangent_count.x + tangent_count.y : 1;
    int t = 0;
    do {
        int j = t < tangent_count.x ? 0 : 1;
        float eta = j == 0 ? warp.eta : weft.eta;
        float k_d = j == 0 ? warp.k_d : weft.k_d;
        float gamma_s = j == 0 ? warp.gamma_s : weft.gamma_s;
        float gamma_v = j == 0 ? warp.gamma_v : weft.gamma_v;
        Tangent tangent = fetch_tangent(t);
        vec3 i = tangent_from_surface(omega_i, j, tangent.cos_tilt, tangent.sin_tilt);
        vec3 o = tangent_from_surface(omega_o, j, tangent.cos_tilt, tangent.sin_tilt);
        vec3 terms = tangent_terms(i, o, tangent.weight, eta, k_d, gamma_s, gamma_v, sigma_mask);
        Q += tangent.share * terms.x;
#ifdef WEAVE
        terms.yz *= seen_of(rel_and_turn(t), j, omega_i);
#endif
        terms_1 += j == 0 ? terms.yz : vec2(0.0);
        terms_2 += j == 0 ? vec2(0.0) : terms.yz;
        ++t;
    } while (t < last);
#ifdef WEAVE
    vec3 sum = COLORED(vec4(terms_1, terms_2));
#else
    vec3 sum = terms_1.x + terms_2.x + warp.A * terms_1.y + weft.A * terms_2.y;
#endif
    return lit && Q > 0.0 ? sum / Q : vec3(0.0);
}
