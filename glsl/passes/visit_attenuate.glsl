// What a traversal looks for: what is left of the light along a ray. Cloth attenuates, anything else blocks, and so do
// more than eight layers of cloth.
// A triangle may be met in several leaves: a hit counts in the one it lies in, and once; so do two hits within a hair, as
// on an edge that two triangles share. Layers of cloth are noted first and reckoned together, because the rays of one
// SIMD vector meet them at different steps.
#include "trace/shared.glsl"
#include "passes/surface_at.glsl"
#include "passes/transmission.glsl"

const int NOTED_LAYERS = 8;

struct Visit {
    vec3 through;
    float t;       // nothing beyond matters: t_max, or 0 when no light is left
    float counted;  // t of the latest hit that counted
    int layers;    // noted and not reckoned yet
    uvec4 latest;  // their triangles, the latest first; shifted along, because an indexed array goes through memory
    uvec4 earlier;
};

Visit start_visit(float t_max) {
    return Visit(vec3(1.0), t_max, -1.0, 0, uvec4(0u), uvec4(0u));
}

float reach(Visit visit) { return visit.t; }

// Lets the light through the layers that were noted.
void reckon(inout Visit visit, Ray ray) {
    for (int k = 0; k < visit.layers; ++k) {
        int i = int(visit.latest.x);
        visit.latest = uvec4(visit.latest.yzw, visit.earlier.x);
        visit.earlier = visit.earlier.yzwx;
        vec4 hit = meet_triangle(ray, uintBitsToFloat(texelFetch(corner_data, 3 * i).xyz),
                                 uintBitsToFloat(texelFetch(corner_data, 3 * i + 1).xyz),
                                 uintBitsToFloat(texelFetch(corner_data, 3 * i + 2).xyz));
        Surface s = surface_at(i, hit.yz, -ray.d);
        vec3 omega = vec3(dot(ray.d, s.x), dot(ray.d, cross(s.N, s.x)), dot(ray.d, s.N));
        visit.through *= T_sheet(omega, k_a, 0.5 * k_t, tau, rho);
    }
    visit.layers = 0;
}

void meet(inout Visit visit, Ray ray, uint tag, vec4 hit, vec2 window) {
    float hair = 1e-5 * (1.0 + hit.x);
    bool inside = hit.x > ray.t_min && hit.x < visit.t && hit.x >= window.x - hair && hit.x <= window.y + hair;
    if (!inside || abs(visit.counted - hit.x) < hair) return;
    visit.counted = hit.x;
    bool blocked = (tag & SOLID) != 0u || visit.layers == NOTED_LAYERS;
    visit.through = blocked ? vec3(0.0) : visit.through;
    visit.t = blocked ? 0.0 : visit.t;
    visit.earlier = uvec4(visit.latest.w, visit.earlier.xyz);
    visit.latest = uvec4(tag, visit.latest.xyz);
    visit.layers += 1;
}
