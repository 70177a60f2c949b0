#version 430
// Shades the covered pixels of a picture by what is included as "shade.glsl".
#include "shade.glsl"

void main() { shade(ivec2(gl_FragCoord.xy)); }
