// What the pixel that is being shaded sees of each light: "seen.glsl" of a program with shadows.
#include "trace/visibility.glsl"
layout(binding = 2) uniform sampler2DArray seen;  // layers: V_0, V_1 .. V_K, six of the broad light, the suns
uniform int broad_layer;    // of the first of the six, 0: there are none
uniform int sun_layer;      // of the first sun
uniform vec3 rho;           // directional albedo of the fabric
ivec2 seen_from;
vec3 V_plus, V_minus;

float V_layer(int layer) { return texelFetch(seen, ivec3(seen_from, layer), 0).x; }

void look_from(ivec2 pixel) {
    seen_from = pixel;
    V_plus = vec3(V_layer(broad_layer), V_layer(broad_layer + 1), V_layer(broad_layer + 2));
    V_minus = vec3(V_layer(broad_layer + 3), V_layer(broad_layer + 4), V_layer(broad_layer + 5));
}

float V_gaussian(int k) { return V_layer(1 + k); }

float V_sun(int s) { return V_layer(sun_layer + s); }

// Of the light that is summed over several Gaussians, from a direction of world space.
float V_broad(vec3 omega) { return from_cube(omega, V_plus, V_minus); }

vec3 with_bounce(vec3 L) { return bounced(L, rho, V_layer(0)); }
