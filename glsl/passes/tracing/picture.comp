#version 430
// Adds one sample of a tile to the picture, top row first; PARTED: also its kinds of light, pixel by pixel.
#include "trace/shared.glsl"
layout(local_size_x = 64) in;
#include "inputs/gpu/item.glsl"
#ifdef PARTED
#include "inputs/tracing/parts.glsl"
layout(std430) buffer PictureParts { vec4 picture_kinds[]; };
#endif
uniform samplerBuffer radiances;
layout(std430) buffer Picture { vec4 picture[]; };
uniform ivec2 size;
uniform ivec2 tile_first;
uniform ivec2 tile_blocks;
uniform float share;  // 1 / samples

void main() {
    int i = item();
    if (i >= 8 * tile_blocks.x * tile_blocks.y) return;
    ivec2 block = ivec2(i / 8 / tile_blocks.y, i / 8 % tile_blocks.y);
    ivec2 pixel = tile_first + block * ivec2(BLOCK_WIDTH, BLOCK_HEIGHT) + ivec2(i % BLOCK_WIDTH, i / BLOCK_WIDTH % BLOCK_HEIGHT);
    if (any(greaterThanEqual(pixel, size))) return;
    int place = (size.y - 1 - pixel.y) * size.x + pixel.x;
    picture[place] += vec4(share * texelFetch(radiances, i).rgb, 1.0);
#ifdef PARTED
    for (int k = 0; k < LIGHT_PARTS; ++k) picture_kinds[LIGHT_PARTS * place + k] += share * kinds[LIGHT_PARTS * i + k];
#endif
}
