// The light of the lamp and the even light at a surface, without shadows.   [Mat 1, section 4.2 step 5]
#include "inputs/picture/fabric.glsl"
#include "inputs/tracing/surface_at.glsl"
#include "inputs/tracing/transmission.glsl"

uniform vec3 lamp;               // its position
uniform vec3 intensity;          // W/sr
uniform vec3 ambient;            // radiance of the even light in the room
#ifndef FABRICS
uniform vec3 cloth_albedo;       // of the fabric in even light
uniform float reflection_limit;  // dims the yarns' reflection so that no energy is gained
#endif

struct LampRay {
    vec3 direction;  // toward the lamp
    vec3 E;          // irradiance across the direction
    bool behind;     // the lamp is on the other side than the viewer
};

LampRay lamp_ray(vec3 p, Surface s) {
    vec3 l = lamp - p;
    float distance_2 = max(dot(l, l), 1e-12);
    l *= inversesqrt(distance_2);
    return LampRay(l, intensity / distance_2, dot(s.N_g, l) < 0.0);
}

vec3 even_light(Surface s) {
    return ambient * (s.cloth ? cloth_albedo : s.diffuse);
}

// Radiance of a surface that is not cloth in the lamp's light.
vec3 lamp_light_solid(Surface s, LampRay l) {
    return s.diffuse * l.E * (l.behind ? 0.0 : max(dot(l.direction, s.N), 0.0) / PI);
}

// Radiance of cloth toward omega_o (surface frame) in the lamp's light.
vec3 lamp_light_cloth(mat3 world_from_surface, vec3 omega_o, LampRay l) {
    vec3 omega_i = l.direction * world_from_surface;
    if (!l.behind) return reflection_limit * l.E * f_cloth(omega_i, omega_o);
    // The functions have z = N on the light's side.
    vec3 i_t = vec3(omega_i.xy, -omega_i.z);
    vec3 o_t = vec3(omega_o.xy, -omega_o.z);
    return l.E * absorption(i_t, o_t, tau)
           * f_through(i_t, o_t, k_t, rho, roughness, eta_1, eta_2, diffuse, roughness_p);
}

vec3 lamp_light(Surface s, mat3 world_from_surface, vec3 omega_o, LampRay l) {
    return s.cloth ? lamp_light_cloth(world_from_surface, omega_o, l) : lamp_light_solid(s, l);
}
