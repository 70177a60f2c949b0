// Light that comes from the room, the curtain and the sky, and not straight from the lamp: irradiance, from the estimates among
// photons that glcloth/curtain/photons.py makes.
#include "inputs/accel/nearest_points.glsl"
#include "inputs/tracing/flat_cloth.glsl"
uniform usamplerBuffer cloth_light;  // of each piece: of the nodes on its front, row by row from the top, then on its back: two texels, (-) (W/m^2, -)
uniform ivec2 cloth_nodes;           // across and down
uniform vec4 cloth_width;            // of the flat pieces, m
uniform vec4 cloth_height;

vec3 indirect_on_solid(int triangle, vec3 p, vec3 N_g) { return nearest_mean(p, N_g); }

vec3 node_light(int node) { return uintBitsToFloat(texelFetch(cloth_light, 2 * node + 1).xyz); }

vec3 cloth_light_at(int side, ivec2 node, vec2 f) {
    int k = (side * cloth_nodes.y + node.y) * cloth_nodes.x + node.x;
    vec3 low = mix(node_light(k), node_light(k + 1), f.x);
    k += cloth_nodes.x;
    return mix(low, mix(node_light(k), node_light(k + 1), f.x), f.y);
}

// On the side that N points to, and on the other one.
void indirect_on_cloth(int triangle, vec2 weights, vec3 p, vec3 N, out vec3 E, out vec3 E_behind) {
    FlatPlace place = flat_place(triangle, weights, N);
    vec2 last = vec2(cloth_nodes - 1);
    vec2 size = vec2(cloth_width[place.piece], cloth_height[place.piece]);
    vec2 at = clamp(vec2(place.p.x - flat_begin[place.piece], -place.p.y) / size * last, vec2(0.0), last);
    ivec2 node = min(ivec2(at), cloth_nodes - 2);
    vec2 f = at - vec2(node);
    E = cloth_light_at(2 * place.piece + place.side, node, f);
    E_behind = cloth_light_at(2 * place.piece + 1 - place.side, node, f);
}
