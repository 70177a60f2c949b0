#version 430
// The depth of the pixels that are fine enough to show threads, or of the others; 1 elsewhere.
#include "inputs/picture/pixel_uv.glsl"
uniform sampler2D depth;
uniform float far_footprint;  // metres of cloth, the shorter side of a pixel from which on it shows none
uniform bool wants_near;

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    bool covered = texelFetch(frame_N, pixel, 0).w != 0.0;
    PixelUv at = pixel_uv(pixel);
    bool near = min(length(at.x), length(at.y)) < far_footprint;
    gl_FragDepth = covered && near == wants_near ? texelFetch(depth, pixel, 0).r : 1.0;
}
