// A traversal looks for the light that is left along a ray. Cloth attenuates, anything else blocks, and so do
// more than eight layers of cloth.
// A triangle may be met in several leaves: a hit counts in the one it lies in. Layers of cloth are noted first and reckoned
// together, because the rays of one SIMD vector meet them at different steps; in the order of their triangles, each once,
// so that the product is the same to the last bit whatever the structure. Two hits within a hair, as on an edge that two
// triangles share, are one layer.
#include "trace/shared.glsl"
#include "inputs/tracing/surface_at.glsl"
#include "inputs/tracing/transmission.glsl"
#ifdef HOLES
#include "inputs/tracing/holes.glsl"
#endif

#ifndef FABRICS
uniform float straight_share;  // of the yarns' light that passes, what goes on straight to the lamp
#endif

const int NOTED_LAYERS = 8;

struct Visit {
    float t;       // nothing beyond matters: t_max, or 0 when no light is left
    int layers;    // noted and not reckoned yet
    uvec4 latest;  // their triangles, the latest first; shifted along, because an indexed array goes through memory
    uvec4 earlier;
};

Visit start_visit(float t_max) {
    return Visit(t_max, 0, uvec4(NO_TRIANGLE), uvec4(NO_TRIANGLE));
}

float t_limit(Visit visit) { return visit.t; }

uint lowest(uvec4 a, uvec4 b) {
    uvec4 m = min(a, b);
    return min(min(m.x, m.y), min(m.z, m.w));
}

// The light that the noted layers let through.
vec3 reckon(Visit visit, Ray ray) {
    vec3 through = vec3(visit.t > 0.0 ? 1.0 : 0.0);
    vec4 latest_t = vec4(-1.0);
    vec4 earlier_t = vec4(-1.0);
    uint triangle = lowest(visit.latest, visit.earlier);
    do {
        // Cross it off.
        visit.latest |= NO_TRIANGLE * uvec4(equal(visit.latest, uvec4(triangle)));
        visit.earlier |= NO_TRIANGLE * uvec4(equal(visit.earlier, uvec4(triangle)));
        int i = triangle == NO_TRIANGLE ? 0 : int(triangle);
        vec4 hit = meet_triangle(ray, uintBitsToFloat(texelFetch(corner_data, 3 * i).xyz),
                                 uintBitsToFloat(texelFetch(corner_data, 3 * i + 1).xyz),
                                 uintBitsToFloat(texelFetch(corner_data, 3 * i + 2).xyz));
        float hair = 1e-5 * (1.0 + hit.x);
        bool known = any(lessThan(abs(latest_t - hit.x), vec4(hair))) || any(lessThan(abs(earlier_t - hit.x), vec4(hair)));
        Surface s = surface_at(i, hit.yz, -ray.d);
        vec3 omega = vec3(dot(ray.d, s.x), dot(ray.d, cross(s.N, s.x)), dot(ray.d, s.N));
        bool counts = triangle != NO_TRIANGLE && !known;
#ifdef FABRICS
        take_fabric(i);
#endif
#ifdef HOLES
        // Of the light to a pixel: what it covers, drawn together toward the lamp.
        vec3 end = ray.o + ray.t_max * ray.d;
        float width = pixel_width(end) * distance(ray.o + hit.x * ray.d, shines_from) / max(distance(end, shines_from), 1e-6);
        float hole = hole_at(i, hit.yz, width, omega.z);
        vec3 T = T_sheet_at(omega, k_a, straight_share * k_t, tau, rho, hole, hole_mean);
#else
        vec3 T = T_sheet(omega, k_a, straight_share * k_t, tau, rho);
#endif
        through *= counts ? T : vec3(1.0);
        earlier_t = vec4(latest_t.w, earlier_t.xyz);
        latest_t = vec4(hit.x, latest_t.xyz);
        triangle = lowest(visit.latest, visit.earlier);
    } while (triangle != NO_TRIANGLE);
    return through;
}

void accept(inout Visit visit, Ray ray, uint tag, vec4 hit, vec2 window) {
    // The same for all hits of a leaf.
    float first = max(window.x - 1e-5 * (1.0 + window.x), ray.t_min);
    float last = min(window.y + 1e-5 * (1.0 + window.y), ray.t_max);
    if (!(hit.x > first && hit.x < last) || tag == visit.latest.x) return;
    bool blocked = (tag & SOLID) != 0u || visit.layers == NOTED_LAYERS;
    visit.t = blocked ? 0.0 : visit.t;
    visit.earlier = uvec4(visit.latest.w, visit.earlier.xyz);
    visit.latest = uvec4(tag, visit.latest.xyz);
    visit.layers += 1;
}
