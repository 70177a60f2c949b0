#version 430
// Clears the coarse picture; its depth is 0 where the pixel that it samples is covered, else 1.
#include "inputs/picture/gbuffer.glsl"
uniform int pixel_stride;
out vec4 color;

void main() {
    ivec2 pixel = min(ivec2(gl_FragCoord.xy) * pixel_stride, textureSize(frame_N, 0) - 1);
    color = vec4(0.0);  // alpha 0 says that nothing is there
    gl_FragDepth = texelFetch(frame_N, pixel, 0).w != 0.0 ? 0.0 : 1.0;
}
