#version 430
// Shades the hits of one generation of rays and makes the next: the transmitted ray and the mirrored one.
// [Mat section 4.2, steps 4 and 5]
//
// L_out = T_sheet L(straight on) + R_sheet L(mirrored) + (yarns' transmission or reflection) E V + ambient: the lamp's part
// waits in the shadow queue until its visibility V is known. Rays of the next generation lie in two runs: transmitted ones
// from the front, mirrored ones from the back.
// A ray is (weight, layer): the layer belongs to a head, the origin and direction of a straight way. When `layered`, the
// head's layers have all been found at once and a transmitted ray is its parent's next layer; otherwise it is a new head.
// Defines: CLOTH, 1: the rays that hit cloth, 0: the others (passes/tracing/sort.comp parts them). SPREAD, 1: draw the
// transmitted direction from the lobes instead of going straight on. GI, 1: light comes from all around the room instead of
// `ambient` ("indirect.glsl" finds it), and what cloth lets through is split as in woven/sheet.glsl: T_straight goes on,
// T_lambert is scattered. HOLES: holes
// are where the weave has them, instead of everywhere alike; WEAVE and its kin: so are threads (inputs/tracing/threads.glsl).
// PARTED: keep the kinds of light of these rays apart.
#include "trace/shared.glsl"
#include "trace/intersect.glsl"
#include "trace/spread.glsl"
#include "core/equirect.glsl"
#include "inputs/tracing/local_light.glsl"
#include "inputs/accel/ray.glsl"
#include "inputs/tracing/claim.glsl"
#ifdef HOLES
#include "inputs/tracing/holes.glsl"
#endif
#if GI == 1
#include "indirect.glsl"
#endif
#ifdef PARTED
#include "inputs/tracing/parts.glsl"
#endif

layout(local_size_x = 64) in;
#include "inputs/gpu/item.glsl"
uniform sampler2D environment_map;
uniform usamplerBuffer layers;    // (t, triangle, v, w), `stride` for each head
uniform usamplerBuffer order;     // the rays to shade
uniform samplerBuffer heads;     // (origin, t_min) (direction, t_max)
uniform samplerBuffer weights;   // (weight, layer)
layout(std430) writeonly buffer Heads { vec4 head_out[]; };
layout(std430) writeonly buffer Weights { vec4 weight_out[]; };
layout(std430) writeonly buffer Radiances { vec4 radiance[]; };
layout(std430) writeonly buffer Children { uvec2 children[]; };
layout(std430) writeonly buffer Shadows { vec4 shadow_out[]; };  // (origin, ray) (radiance, its kind)
uniform int stride;
uniform bool layered;
uniform int next_last;       // the last place in the next generation's queue; mirrored rays fill it from here down
uniform uint head_capacity;  // heads beyond it, and rays beyond the queue, are counted and not kept
uniform int level;
uniform int last_level;
uniform int generation_seed;  // of the sample and the level
uniform float far;           // beyond everything
uniform float cutoff;        // rays that count for less are not followed
uniform float offset;        // how far off the surface new rays begin
uniform vec3 background;
uniform bool has_environment;
uniform mat3 environment_from_world;

vec3 sky(vec3 d) {
    if (!has_environment) return background;
    return textureLod(environment_map, uv_from_direction(normalize(environment_from_world * d)), 0.0).rgb;
}

void main() {
    begin_claims();
    uint place = uint(item());
    uint rays = count[CLOTH == 1 ? ON_CLOTH : ELSEWHERE];
    bool live = place < rays;
    // Invocations behind the end shade the last ray again, and keep it to themselves.
    place = min(place, rays - 1u) + (CLOTH == 1 ? 0u : count[ON_CLOTH]);
    int i = int(texelFetch(order, int(place)).x);
    vec4 weight = texelFetch(weights, i);
    int layer = floatBitsToInt(weight.a);
    int head = layer / stride;
    vec3 d = texelFetch(heads, 2 * head + 1).xyz;
    uvec4 hit = texelFetch(layers, layer);
    bool met = hit.y != NO_TRIANGLE;
    float t = uintBitsToFloat(hit.x);
    vec3 o = texelFetch(heads, 2 * head).xyz;
    vec3 p = o + t * d;
    int triangle = met ? int(hit.y) : 0;
    // The traversal keeps no weights: found again once, they cost less than at every test.
    vec2 at = meet_triangle(make_ray(o, d, 0.0, 0.0), uintBitsToFloat(texelFetch(corner_data, 3 * triangle).xyz),
                            uintBitsToFloat(texelFetch(corner_data, 3 * triangle + 1).xyz),
                            uintBitsToFloat(texelFetch(corner_data, 3 * triangle + 2).xyz)).yz;
    Surface s = surface_at(triangle, at, -d);
    LampRay l = lamp_ray(p, s);
#if CLOTH == 0
    vec3 direct = weight.rgb * lamp_light_solid(s, l);
#if GI == 1
    vec3 even = vec3(0.0);
    if (met) even = s.diffuse * indirect_on_solid(triangle, p, s.N_g) / PI;
#else
    vec3 even = even_light(s);
#endif
    vec3 seen = weight.rgb * (met ? even : sky(d));
    const bool goes_on = false, is_mirrored = false;
    const uint onward_heads = 0u;
#else
#ifdef FABRICS
    take_fabric(triangle);
#endif
    mat3 world_from_surface = mat3(s.x, cross(s.N, s.x), s.N);
    vec3 omega_o = -d * world_from_surface;
#ifdef HOLES
    float hole = hole_at(triangle, at, pixel_width(p), omega_o.z), yarns = yarns_at(hole);
#ifdef WEAVE
    float covers = fetch_threads(place_of_hit(triangle, at), slanted(pixel_width(p), omega_o.z), threads_shown(pixel_width(p)));
#else
    float covers = yarns;
#endif
#define THROUGH(k) T_sheet_at(omega_o, k_a, k, tau, rho, hole, hole_mean)
#else
    const float yarns = 1.0, covers = 1.0;
#define THROUGH(k) T_sheet(omega_o, k_a, k, tau, rho)
#endif
#ifdef WEAVE
    // What is reflected has the weights of the place already.
    float lit = l.behind ? covers : 1.0;
#else
    float lit = covers;
#endif
    vec3 direct = weight.rgb * lit * lamp_light_cloth(world_from_surface, omega_o, l);
#if GI == 1
    vec3 E, E_behind;
    indirect_on_cloth(triangle, at, p, s.N, E, E_behind);
    vec3 even = cloth_albedo * E / PI;
    vec3 through = THROUGH(k_t * (1.0 - 0.5 * diffuse));
#if SPREAD == 0
    vec3 scattered = T_lambert(omega_o, k_t, tau, rho, diffuse) * E_behind / PI;
    even += scattered;
#else
    const vec3 scattered = vec3(0.0);
#endif
#else
    vec3 even = even_light(s);
    vec3 through = THROUGH(k_t);
    const vec3 scattered = vec3(0.0);
#endif
    vec3 seen = weight.rgb * covers * even;
    vec4 from = vec4(o, behind_layer(t));
    vec3 onward = d;
#if SPREAD == 1
    // The seed is made of the ray, not of its place in the queue, which depends on timing.
    uvec3 hash = hash3(uvec3(floatBitsToUint(d.x), floatBitsToUint(d.y), uint(generation_seed)));
    vec4 parts = straight_parts(omega_o, k_a, k_t, tau, rho);
    float chance = hole_chance(parts);
    float pick = unit_square(hash.zz).x;
    bool hole = pick < chance;
    through = drawn_weight(parts, int(hole));
    float part = (pick - chance) / max(1.0 - chance, 1e-12);
    vec3 drawn = world_from_surface * (hole ? -omega_o : yarn_direction(omega_o, unit_square(hash.xy), part, roughness, eta_1,
                                                                        eta_2, diffuse, roughness_p));
    if (dot(drawn, s.N_g) < 0.0) {
        onward = drawn;
        from = vec4(p - offset * s.N_g, 0.0);
    }
#endif
    through *= weight.rgb;
    float R = yarns * R_sheet(omega_o, k_t, rho, eta_1, eta_2);
    vec3 mirrored = weight.rgb * R_limited(R, THROUGH(k_t), min(yarns * cloth_albedo, 1.0));
    bool goes_on = live && level < last_level && largest(through) > cutoff;
    bool is_mirrored = live && level < last_level && largest(mirrored) > cutoff;
    uint onward_heads = goes_on && !layered ? 1u : 0u;
#endif
    bool waits = live && met && largest(direct) > 1e-5 * cutoff;
    // ONWARD, MIRRORED, WAITING, HEADS.
    uint places = claim(uvec4(goes_on, is_mirrored, waits, onward_heads + uint(is_mirrored)));
    settle_claims();

    uvec2 next = uvec2(NO_TRIANGLE);
#if CLOTH == 1
    if (goes_on) {
        next.x = place_of(ONWARD, places);
        int next_layer = layer + 1;
        if (!layered) {
            uint k = place_of(HEADS, places);
            if (k < head_capacity) {
                head_out[2u * k] = from;
                head_out[2u * k + 1u] = vec4(onward, far);
            }
            next_layer = int(k) * stride;
        }
        if (next.x <= uint(next_last)) weight_out[next.x] = vec4(through, intBitsToFloat(next_layer));
    }
    if (is_mirrored) {
        next.y = uint(next_last) - place_of(MIRRORED, places);
        uint k = place_of(HEADS, places) + onward_heads;
        if (k < head_capacity) {
            head_out[2u * k] = vec4(p + offset * s.N_g, 0.0);
            head_out[2u * k + 1u] = vec4(mirrored_direction(d, s.N, s.N_g), far);
        }
        if (next.y <= uint(next_last)) weight_out[next.y] = vec4(mirrored, intBitsToFloat(int(k) * stride));
    }
#endif
    if (live) {
        radiance[i] = vec4(seen, 0.0);
        children[i] = next;
#ifdef PARTED
        int k = LIGHT_PARTS * i;
        kinds[k + DIRECT] = vec4(0.0);
#if CLOTH == 1
        vec3 behind = weight.rgb * covers * scattered;
        kinds[k + BOUNCE] = vec4(seen - behind, 0.0);
        kinds[k + THROUGH] = vec4(behind, 0.0);
        kinds[k + BEYOND] = vec4(0.0);
#else
        kinds[k + BOUNCE] = vec4(met ? seen : vec3(0.0), 0.0);
        kinds[k + THROUGH] = vec4(0.0);
        kinds[k + BEYOND] = vec4(met ? vec3(0.0) : seen, 0.0);
#endif
#endif
    }
    if (waits) {
        uint k = place_of(WAITING, places);
        shadow_out[2u * k] = vec4(p + (l.behind ? -offset : offset) * s.N_g, intBitsToFloat(i));
        shadow_out[2u * k + 1u] = vec4(direct, l.behind ? 1.0 : 0.0);
    }
}
