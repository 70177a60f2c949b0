#version 430
// The depth of the coarse picture: 0 where the pixel that it samples is covered, else 1.
#include "passes/gbuffer.glsl"
uniform int pixel_stride;

void main() {
    ivec2 pixel = min(ivec2(gl_FragCoord.xy) * pixel_stride, textureSize(frame_N, 0) - 1);
    gl_FragDepth = texelFetch(frame_N, pixel, 0).w != 0.0 ? 0.0 : 1.0;
}
