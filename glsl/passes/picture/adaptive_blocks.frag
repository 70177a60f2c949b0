#version 430
// Says which blocks of 4 x 4 pixels are smooth: what every second pixel of every second row there would show as cloth from
// afar follows from the four corners, where terms are known. 1: smooth.   [own]
#include "inputs/picture/adaptive.glsl"
uniform sampler2D near_depth;  // 1 where a pixel shows no threads, or is not covered
out vec4 color;

bool follows(ivec2 block, ivec2 odd) {
    ivec2 pixel = 4 * block + 2 * odd;
    if (texelFetch(near_depth, pixel, 0).r == 1.0) return false;
    // On the far sides of the block it lies on the line to the next one.
    ivec2 low = pixel >> 2;
    return interpolated(low, (pixel >> 1) & 1, texelFetch(frame_N, pixel, 0)).a > 0.0;
}

void main() {
    ivec2 block = ivec2(gl_FragCoord.xy);
    color = vec4(0.0);
    // A corner beyond the picture would be a pixel elsewhere.
    if (any(greaterThanEqual(4 * block + 4, textureSize(frame_N, 0)))) return;
    if (follows(block, ivec2(1, 1)) && follows(block, ivec2(1, 0)) && follows(block, ivec2(0, 1)) && follows(block, ivec2(2, 1))
        && follows(block, ivec2(1, 2))) color = vec4(1.0);
}
