#version 430
// Fills every second pixel of every second row from every fourth of every fourth, where blocks are smooth.   [own]
#include "inputs/picture/adaptive.glsl"
#include "inputs/picture/smooth_blocks.glsl"
out vec4 color;

void main() {
    ivec2 at = ivec2(gl_FragCoord.xy);
    if (!among_smooth(at)) discard;
    ivec2 odd = at & 1, low = at >> 1;
    color = odd.x + odd.y == 0 ? coarse_at(low) : interpolated(low, odd, texelFetch(frame_N, 2 * at, 0));
}
