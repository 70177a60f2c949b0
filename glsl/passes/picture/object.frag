#version 430
// Shades objects with textures, gloss and metal, where they are seen: GGX over Lambertians, in the light of "lit.glsl".
#include "inputs/picture/shade_object.glsl"

void main() { shade(ivec2(gl_FragCoord.xy)); }
