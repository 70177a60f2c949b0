#version 430
// The rasterised picture: every surface in the lamp's light without shadows; cloth covers others behind it by the share
// that does not pass straight on.   [Mat section 3, figure 2]
#include "inputs/tracing/local_light.glsl"
uniform vec4 viewpoint;  // (eye, 1), or of parallel rays (direction toward the camera, 0)
in vec3 p;
in vec3 weights;
flat in int triangle;
out vec4 color;

void main() {
    vec3 o = normalize(viewpoint.xyz - viewpoint.w * p);
    Surface s = surface_at(triangle, weights.yz, o);
#ifdef FABRICS
    take_fabric(triangle);
#endif
    mat3 world_from_surface = mat3(s.x, cross(s.N, s.x), s.N);
    vec3 omega_o = o * world_from_surface;
    vec3 L = even_light(s) + lamp_light(s, world_from_surface, omega_o, lamp_ray(p, s));
    vec3 through = s.cloth ? T_sheet(omega_o, k_a, k_t, tau, rho) : vec3(0.0);
    // Blending has one share for all colours.
    color = vec4(L, 1.0 - dot(through, vec3(1.0 / 3.0)));
}
