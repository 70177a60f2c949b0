#version 430
// Adds what comes through cloth from its other side, but for what goes straight on; and what its yarns mirror.   [own]
#include "inputs/picture/shade_through.glsl"

void main() { shade(ivec2(gl_FragCoord.xy)); }
