// Light that comes from the room, the curtain and the sky, and not straight from the lamp: irradiance, from the estimates among
// photons that glcloth/curtain/photons.py makes.
#include "inputs/accel/nearest_points.glsl"
#include "inputs/tracing/flat_cloth.glsl"

vec3 photon_light(vec3 p, vec3 n) {
    Nearest near = nearest_points(p, n);
    return near.sum / max(near.weight, 1e-20);
}

vec3 indirect_on_solid(int triangle, vec3 p, vec3 N_g) { return photon_light(p, N_g); }

// On the side that N points to, and on the other one.
void indirect_on_cloth(int triangle, vec2 weights, vec3 p, vec3 N, out vec3 E, out vec3 E_behind) {
    FlatPlace place = flat_place(triangle, weights, N);
    vec3 both[2];
    int k = 0;
    do {
        both[k] = photon_light(place.p * vec3(1.0, 1.0, 1 - 2 * k), place.n * float(1 - 2 * k));
        ++k;
    } while (k < 2);
    E = both[0];
    E_behind = both[1];
}
