// Blocks of 4 x 4 pixels that are smooth: see passes/picture/adaptive_blocks.frag.
uniform sampler2D smooth_blocks;

// Whether all blocks that touch a pixel, one of every second of every second row, are.
bool among_smooth(ivec2 coarse_pixel) {
    ivec2 high = coarse_pixel >> 1, low = max((coarse_pixel - 1) >> 1, 0);
    return min(min(texelFetch(smooth_blocks, low, 0).r, texelFetch(smooth_blocks, high, 0).r),
        min(texelFetch(smooth_blocks, ivec2(low.x, high.y), 0).r, texelFetch(smooth_blocks, ivec2(high.x, low.y), 0).r)) > 0.5;
}
