#version 430
// Clears the coarse picture; its depth is 0 where the pixel that it samples is covered, else 1.
#ifdef OF_A_PART
uniform sampler2D part_depth;  // 1 where a pixel is not of this part of the picture
#else
#include "inputs/picture/gbuffer.glsl"
#endif
#ifdef OF_BLOCKS
#include "inputs/picture/smooth_blocks.glsl"  // then only beside blocks that are not smooth
#endif
uniform int pixel_stride;
out vec4 color;

void main() {
#ifdef OF_A_PART
    ivec2 pixel = min(ivec2(gl_FragCoord.xy) * pixel_stride, textureSize(part_depth, 0) - 1);
    bool covered = texelFetch(part_depth, pixel, 0).r < 1.0;
#ifdef OF_BLOCKS
    covered = covered && !among_smooth(ivec2(gl_FragCoord.xy));
#endif
#else
    ivec2 pixel = min(ivec2(gl_FragCoord.xy) * pixel_stride, textureSize(frame_N, 0) - 1);
    bool covered = texelFetch(frame_N, pixel, 0).w != 0.0;
#endif
    color = vec4(0.0);  // alpha 0 says that nothing is there
    gl_FragDepth = covered ? 0.0 : 1.0;
}
