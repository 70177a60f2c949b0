#version 430
// Shades the covered pixels with the method that is included as "method.glsl".
#include "inputs/picture/shade_cloth.glsl"

void main() { shade(ivec2(gl_FragCoord.xy)); }
