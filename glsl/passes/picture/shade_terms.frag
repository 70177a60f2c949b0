#version 430
// Shades every second or fourth pixel of such rows as cloth from afar, and keeps what each tangent adds to it.   [own]
#include "inputs/picture/shade_terms.glsl"
layout(early_fragment_tests) in;  // a shader that writes to an image is tested late otherwise

void main() { shade(ivec2(gl_FragCoord.xy)); }
