#version 430
// Shades the objects and the ground where they are seen: Lambertians that get the light of "lit.glsl".
#include "inputs/picture/shade_lambert.glsl"

void main() { shade(ivec2(gl_FragCoord.xy)); }
