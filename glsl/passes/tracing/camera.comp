#version 430
// The first generation of rays, one a pixel of a tile. Eight neighbouring invocations take a block of pixels, and blocks
// follow each other downward, so that rays of one SIMD vector stay alike: along a hanging curtain's folds more than across.
// Pixels beyond the tile's edge repeat the last.
#include "trace/shared.glsl"
layout(local_size_x = 64) in;
#include "inputs/gpu/item.glsl"
layout(std430) writeonly buffer Heads { vec4 head_out[]; };      // (origin, t_min) (direction, t_max)
layout(std430) writeonly buffer Weights { vec4 weight_out[]; };  // the ray's weight; its layer
uniform ivec2 size;         // of the picture
uniform ivec2 tile_first;   // its first pixel, rows counted from below
uniform ivec2 tile_blocks;  // how many blocks
uniform vec2 jitter;        // of the sample, in pixels
uniform mat3 origin_from_pixel;
uniform mat3 ray_from_pixel;
uniform float far;
uniform int stride;         // layers that a head has room for

void main() {
    int i = item();
    if (i >= 8 * tile_blocks.x * tile_blocks.y) return;
    ivec2 block = ivec2(i / 8 / tile_blocks.y, i / 8 % tile_blocks.y);
    ivec2 pixel = min(tile_first + block * ivec2(BLOCK_WIDTH, BLOCK_HEIGHT) + ivec2(i % BLOCK_WIDTH, i / BLOCK_WIDTH % BLOCK_HEIGHT), size - 1);
    vec3 at = vec3(vec2(pixel) + 0.5 + jitter, 1.0);
    vec3 d = normalize(ray_from_pixel * at);
    head_out[2 * i] = vec4(origin_from_pixel * at, 0.0);
    head_out[2 * i + 1] = vec4(d, far);
    weight_out[i] = vec4(1.0, 1.0, 1.0, intBitsToFloat(i * stride));
}
