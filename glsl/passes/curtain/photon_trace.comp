#version 430
// Photons of the lamp and of the sky through the cloth and round the room; where they arrive is noted, but for the lamp's own
// light, which shadow rays bring to every point.   [Jensen 1996, "Global illumination using photon maps"]
// At cloth a photon goes straight on, is scattered through, mirrored or reflected, by the energy split of woven/sheet.glsl, or
// ends. Reflection takes the model as the eye does: f_cloth(where it comes from, where it goes), over the cosine of arrival.
#include "trace/random.glsl"
#include "trace/photons.glsl"
#include "inputs/tracing/local_light.glsl"
#include "inputs/tracing/flat_cloth.glsl"
#include "inputs/accel/ray.glsl"
#include "inputs/accel/visit_closest.glsl"
#include "accel.glsl"
layout(local_size_x = 64) in;
#include "inputs/gpu/item.glsl"
layout(std430) writeonly buffer Slots { uvec4 slot[]; };   // twice slots_each a photon: (x, y, z, packed normal) (W, place)
layout(std430) writeonly buffer Found { uint found[]; };   // of each photon; and a last one, 0
uniform samplerBuffer portals;    // three texels each: (corner, share of the lamp's photons up to it) (side, of the sky's) (side, face)
uniform samplerBuffer sky_draws;  // of each face and cell of directions (chance to keep a draw, who gets it else, -, -) (W/m^2)
uniform int portal_count;
uniform int sky_cells;            // directions of a face: SKY_ACROSS of them around, the others up
uniform int lamp_photons;         // the first so many, of
uniform int sky_photons;
uniform bool lamp_inside;         // the lamp's photons go everywhere, and not through the portals alone
uniform int first_photon;
uniform int photon_count;         // of this dispatch
uniform int slots_each;
uniform uint seed;
uniform bool keep_lamp;           // note the lamp's own light too
uniform int solid_triangles;      // of the room, with two places each, front and back; then those of the cloth
uniform float offset;             // how far off the surface new rays begin
uniform float beyond;             // further than this from a point of the scene there is nothing

const int SKY_ACROSS = 64;
const int EVENTS = 96;            // surfaces on a way
const int SURE = 10;              // arrivals before the rest of the light goes on with half of the photons at most
const float LEAST_COSINE = 0.02;

uvec3 state;
vec3 rnd() {
    state.z += 1u;
    return vec3(hash3(state) >> 8u) / 16777216.0;
}
float most(vec3 v) { return max(v.r, max(v.g, v.b)); }

struct Photon {
    vec3 o, d;
    float from;      // hits count beyond
    vec3 W;
    bool lamps_own;  // straight from the lamp
};

// The portal whose share a number from 0 to 1 falls in; the number is stretched to 0 to 1 within it.
int chosen_portal(int kind, inout float u, out float share) {
    int low = 0, high = portal_count - 1;
    while (low < high) {
        int middle = (low + high) / 2;
        vec4 texel = texelFetch(portals, 3 * middle + kind);
        if (u < texel.w) high = middle;
        else low = middle + 1;
    }
    float before = low > 0 ? texelFetch(portals, 3 * (low - 1) + kind).w : 0.0;
    share = texelFetch(portals, 3 * low + kind).w - before;
    u = clamp((u - before) / max(share, 1e-20), 0.0, 0.9999999);
    return low;
}

Photon of_lamp(vec2 u) {
    if (lamp_inside) {
        float z = 1.0 - 2.0 * u.x, s = sqrt(max(1.0 - z * z, 0.0)), phi = 2.0 * PI * u.y;
        return Photon(lamp, vec3(s * cos(phi), s * sin(phi), z), 0.0, intensity * 4.0 * PI / float(lamp_photons), true);
    }
    float share;
    int k = chosen_portal(0, u.x, share);
    vec3 side_u = texelFetch(portals, 3 * k + 1).xyz, side_v = texelFetch(portals, 3 * k + 2).xyz;
    vec3 way = texelFetch(portals, 3 * k).xyz + u.x * side_u + u.y * side_v - lamp;
    float r2 = max(dot(way, way), 1e-12);
    vec3 d = way * inversesqrt(r2);
    vec3 W = intensity * max(dot(cross(side_u, side_v), d), 0.0) / (r2 * share * float(lamp_photons));
    // From the lamp itself, so that it meets what shadow rays meet; where that is far away from nearer by, for the digits of its hits.
    float off = sqrt(r2), back = min(off, beyond);
    return Photon(lamp + (off - back) * d, d, back * (1.0 - 1e-5), W, true);
}

Photon of_sky(vec2 u) {
    float share;
    int k = chosen_portal(1, u.x, share);
    vec3 side_u = texelFetch(portals, 3 * k + 1).xyz, side_v = texelFetch(portals, 3 * k + 2).xyz;
    int face = int(texelFetch(portals, 3 * k + 2).w);
    vec3 across = cross(side_u, side_v), choice = rnd(), place = rnd();
    int cell = min(int(choice.x * float(sky_cells)), sky_cells - 1);
    vec4 kept = texelFetch(sky_draws, 2 * (face * sky_cells + cell));
    cell = choice.y < kept.x ? cell : int(kept.y);
    vec2 at = (vec2(cell / SKY_ACROSS, cell % SKY_ACROSS) + place.xy) / vec2(sky_cells / SKY_ACROSS, SKY_ACROSS);
    vec3 n = normalize(across), x = normalize(side_u);
    vec3 d = mat3(x, cross(n, x), n) * cosine_direction(at);
    vec3 W = texelFetch(sky_draws, 2 * (face * sky_cells + cell) + 1).rgb * length(across) / (share * float(sky_photons));
    vec3 o = texelFetch(portals, 3 * k).xyz + u.x * side_u + u.y * side_v;
    return Photon(o - offset * d, d, 0.0, W, false);
}

// The photon goes on from p on the side of N_g, in a direction that must lie there.
void send(inout Photon photon, vec3 p, vec3 N_g, vec3 d, vec3 W) {
    photon.o = p + offset * N_g;
    photon.d = d;
    photon.from = 0.0;
    photon.W = dot(d, N_g) > 0.0 ? W : vec3(0.0);
    photon.lamps_own = false;
}

void meet_solid(inout Photon photon, Surface s, vec3 p, int arrivals) {
    float chance = min(most(s.diffuse), arrivals < SURE ? 1.0 : 0.5);
    vec3 u = rnd();
    vec3 W = u.z < chance ? photon.W * s.diffuse / max(chance, 1e-20) : vec3(0.0);
    // About N_g: what a smooth normal would send through the triangle would be lost.
    vec3 x = normalize(orthogonal_part(s.x, s.N_g));
    send(photon, p, s.N_g, mat3(x, cross(s.N_g, x), s.N_g) * cosine_direction(u.xy), W);
}

void meet_cloth(inout Photon photon, Surface s, vec3 p, float t) {
    mat3 world_from_surface = mat3(s.x, cross(s.N, s.x), s.N);
    vec3 omega = -photon.d * world_from_surface;
    vec3 straight = T_straight(omega, k_a, k_t, tau, rho, diffuse);
    vec3 evenly = T_lambert(omega, k_t, tau, rho, diffuse);
    float R = R_limited(R_sheet(omega, k_t, rho, eta_1, eta_2), straight + evenly, cloth_albedo);
    vec3 u = rnd();
    vec3 c = cosine_direction(u.xy);
    // Photons arrive and leave by the cosines to the flat triangle, whatever the smooth normal is.   [Veach 1997, section 5.3]
    vec3 d_new = world_from_surface * c;
    float bent = max(dot(d_new, s.N_g), 0.0) / max(c.z, LEAST_COSINE);
    vec3 f = reflection_limit * f_cloth(omega, c) * PI * bent / max(-dot(photon.d, s.N_g), LEAST_COSINE);
    vec3 chance = vec3(most(straight), most(evenly), R);
    chance /= max(dot(chance, vec3(1.0)), 1.0);
    // Where it would go is known: as often as it weighs, so that those that go weigh alike.
    float passed = dot(chance, vec3(1.0));
    float reflected = min(most(f), 1.0 - passed);
    vec3 W = photon.W, d = photon.d;
    if (u.z < chance.x) {
        photon.W = W * straight / chance.x;
        photon.from = behind_layer(t);
    } else if (u.z < chance.x + chance.y) {
        send(photon, p, -s.N_g, world_from_surface * vec3(c.xy, -c.z), W * evenly / chance.y);
    } else if (u.z < passed) {
        send(photon, p, s.N_g, mirrored_direction(d, s.N, s.N_g), W * R / chance.z);
    } else {
        bool goes = u.z < passed + reflected;
        send(photon, p, s.N_g, d_new, goes ? W * f / reflected : vec3(0.0));
    }
}

void main() {
    int i = item();
    if (i >= photon_count) return;
    int number = first_photon + i;
    state = uvec3(uint(number), seed, 0u);
    bool from_lamp = number < lamp_photons;
    uint k = uint(from_lamp ? number : number - lamp_photons);
    vec2 shift = unit_square(hash3(uvec3(seed, from_lamp ? 1u : 2u, 77u)).xy);
    vec2 u = shifted_hammersley(k, uint(from_lamp ? lamp_photons : sky_photons), shift);
    Photon photon;
    if (from_lamp) photon = of_lamp(u);
    else photon = of_sky(u);
    int arrivals = 0, events = 0;
    bool more = most(photon.W) > 0.0;
    do {
        float far = photon.from + beyond;
        Visit visit = Visit(far, NO_TRIANGLE, vec2(0.0));
        traverse(make_ray(photon.o, photon.d, photon.from, far), visit);
        more = more && visit.triangle != NO_TRIANGLE;
        if (more) {
            int triangle = int(visit.triangle);
            vec3 p = photon.o + visit.t * photon.d;
            Surface s = surface_at(triangle, visit.weights, -photon.d);
            if (!photon.lamps_own || keep_lamp) {
                vec3 n = s.N_g;
                vec3 at = p;
                int place = 2 * triangle + (dot(side_of(triangle), photon.d) > 0.0 ? 1 : 0);
                if (s.cloth) {
                    FlatPlace laid = flat_place(triangle, visit.weights, -photon.d);
                    at = laid.p;
                    n = laid.n;
                    place = 2 * (solid_triangles + laid.piece) + laid.side;
                }
                int to = 2 * (slots_each * i + arrivals);
                slot[to] = uvec4(floatBitsToUint(at), packSnorm2x16(octahedral(n)));
                slot[to + 1] = uvec4(floatBitsToUint(photon.W), uint(place));
                ++arrivals;
            }
#ifdef FABRICS
            take_fabric(triangle);
#endif
            if (s.cloth) meet_cloth(photon, s, p, visit.t);
            else meet_solid(photon, s, p, arrivals);
            more = most(photon.W) > 0.0;
        }
        ++events;
    } while (more && arrivals < slots_each && events < EVENTS);
    found[i] = uint(arrivals);
    if (i == photon_count - 1) found[photon_count] = 0u;
}
