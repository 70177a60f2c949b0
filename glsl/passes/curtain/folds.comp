#version 430
// What a pleated curtain does as a whole: paths of light among its folds, from one side (even numbers: from the room, odd:
// from behind). They begin in front of a random point of its mean plane, as even light does, and meet cloth alone. At each
// layer they go straight on, are scattered through, mirrored or reflected, by chance as much as goes either way. Where the
// lamp lights a layer, what it scatters toward the path is added: the lamp's own rays are cast layer by layer in between,
// by the same traversal.
#include "core/math.glsl"
#include "trace/random.glsl"
#include "inputs/tracing/local_light.glsl"
#include "inputs/accel/ray.glsl"
#include "inputs/accel/visit_closest.glsl"
#include "accel.glsl"
layout(local_size_x = 64) in;
#include "inputs/gpu/item.glsl"
// Of each path: (light that is left, 1: straight, 2: back, 3: through) (the lamp's, 1: scattered, not mirrored alone) (the lamp's
// on layers that are seen, x) and the parts of an irradiance on the front and on the back of the cloth that seen layers show,
// with y and z; x, y, z: the direction from the sheet in which the light goes.
layout(std430) writeonly buffer Paths { vec4 paths[]; };
uniform int path_count;
uniform vec4 sheet;     // where paths begin: least x and y, largest
uniform float sheet_z;
uniform float thick;    // beyond this from the plane there is no cloth
uniform float offset;   // how far off the surface new rays begin
uniform float beyond;   // further than this there is nothing

const int ROUNDS = 64;

void main() {
    int i = item();
    if (i >= path_count) return;
    float side = (i & 1) == 0 ? 1.0 : -1.0;
    uvec3 hash = hash3(uvec3(uint(i), 41u, 3u));
    vec2 at = unit_square(hash.xy);
    hash = hash3(hash);
    vec3 c = cosine_direction(unit_square(hash.xy));
    vec3 d = vec3(c.xy, -side * c.z);
    vec3 toward = -d;
    vec3 o = vec3(mix(sheet.xy, sheet.zw, at), sheet_z) - d * (thick / max(c.z, 0.12));
    vec3 left = vec3(1.0);   // of the path's light
    vec3 lamp_left = vec3(0.0);
    vec3 lamp_sum = vec3(0.0);
    vec3 lamp_seen = vec3(0.0);
    mat2x3 shown = mat2x3(0.0);
    bool scattered = false;  // evenly: what is mirrored or goes straight on is still seen
    bool lamp_is_seen = true;
    vec3 after_o = o, after_d = d;  // where the path goes on after the lamp's ray
    float after_t = 0.0;
    float t_min = 0.0;
    float reach = beyond;
    bool to_lamp = false;
    bool straight_on = true;
    float fate = 0.0;
    int round = 0;
    do {
        Visit visit = Visit(reach, NO_TRIANGLE, vec2(0.0));
        traverse(make_ray(o, d, t_min, reach), visit);
        bool met = visit.triangle != NO_TRIANGLE;
        vec3 p = o + visit.t * d;
        Surface s = surface_at(met ? int(visit.triangle) : 0, visit.weights, -d);
#ifdef FABRICS
        take_fabric(met ? int(visit.triangle) : 0);
#endif
        mat3 world_from_surface = mat3(s.x, cross(s.N, s.x), s.N);
        vec3 omega_o = -d * world_from_surface;
        vec3 straight = T_straight(omega_o, k_a, k_t, tau, rho, diffuse);
        if (to_lamp) {
            lamp_left *= met ? straight : vec3(1.0);
            t_min = behind_layer(visit.t);
            if (!met || largest(lamp_left) < 1e-5) {
                lamp_sum += met ? vec3(0.0) : lamp_left;
                lamp_seen += met || !lamp_is_seen ? vec3(0.0) : lamp_left;
                to_lamp = false;
                o = after_o;
                d = after_d;
                t_min = after_t;
                reach = beyond;
            }
        } else if (!met) {
            fate = straight_on ? 1.0 : d.z * side > 0.0 ? 2.0 : 3.0;
        } else {
            LampRay l = lamp_ray(p, s);
            vec3 omega_i = l.direction * world_from_surface;
            // The lobes of what passes stay near the lamp's straight ray, and belong to it.
            lamp_left = left * l.E * (l.behind
                ? f_lambert(vec3(omega_i.xy, -omega_i.z), vec3(omega_o.xy, -omega_o.z), k_t, tau, rho, diffuse)
                : reflection_limit * f_cloth(omega_i, omega_o));
            vec3 even = T_lambert(omega_o, k_t, tau, rho, diffuse);
            lamp_is_seen = !scattered;
            if (!scattered) shown += s.N.z > 0.0 ? mat2x3(left * cloth_albedo, left * even) : mat2x3(left * even, left * cloth_albedo);
            float R = R_limited(R_sheet(omega_o, k_t, rho, eta_1, eta_2), straight + even, cloth_albedo);
            vec4 chance = vec4(largest(straight), largest(even), R, max(largest(cloth_albedo), 0.02));
            chance /= chance.x + chance.y + chance.z + chance.w;
            hash = hash3(hash);
            float pick = unit_square(hash.zz).x;
            vec3 k = cosine_direction(unit_square(hash.xy));
            after_o = o;
            after_d = d;
            after_t = behind_layer(visit.t);
            if (pick < chance.x) {
                left *= straight / chance.x;
            } else {
                straight_on = false;
                after_t = 0.0;
                bool through = pick < chance.x + chance.y;
                bool mirror = !through && pick < chance.x + chance.y + chance.z;
                scattered = scattered || !mirror;
                left *= through ? even / chance.y : mirror ? vec3(R / chance.z) : cloth_albedo / chance.w;
                after_d = mirror ? mirrored_direction(d, s.N, s.N_g) : world_from_surface * vec3(k.xy, through ? -k.z : k.z);
                after_o = p + (through ? -offset : offset) * s.N_g;
                // A smooth normal may send light to the wrong side of the flat triangle.
                left *= dot(after_d, s.N_g) * (through ? -1.0 : 1.0) > 0.0 ? 1.0 : 0.0;
            }
            if (largest(left) < 1e-4) left = vec3(0.0);
            to_lamp = largest(lamp_left) > 1e-7;
            o = after_o;
            d = after_d;
            t_min = after_t;
            if (to_lamp) {
                o = p + (l.behind ? -offset : offset) * s.N_g;
                d = l.direction;
                t_min = 0.0;
                reach = min(distance(lamp, o) - offset, beyond);
            }
        }
        ++round;
    } while (round < ROUNDS && fate == 0.0 && (to_lamp || left != vec3(0.0)));
    paths[5 * i] = vec4(fate == 0.0 ? vec3(0.0) : left, fate);
    paths[5 * i + 1] = vec4(lamp_sum, scattered ? 1.0 : 0.0);
    paths[5 * i + 2] = vec4(lamp_seen, toward.x);
    paths[5 * i + 3] = vec4(shown[0], toward.y);
    paths[5 * i + 4] = vec4(shown[1], toward.z);
}
