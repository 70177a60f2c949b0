// Visibility of each light from the shaded pixel, where nothing is bounced: "seen.glsl" of a program with shadows.
#include "inputs/visibility/seen_layers.glsl"

void fetch_visibility(ivec2 pixel) { fetch_layers(pixel); }

float V_broad(vec3 omega) { return V_parts(omega); }

vec3 with_bounce(vec3 L) { return L; }
