#version 430
// Lists the covered pixels of a band of a picture, tile by tile, for passes/picture/covered.comp.
layout(local_size_x = 8, local_size_y = 8) in;
uniform sampler2D covered_depth;  // 1 where a pixel is not covered
uniform ivec2 band;               // its first row, and the one behind its last
layout(std430) buffer Covered {
    uvec3 groups;  // the arguments of that dispatch: GROUPS_OF_A_ROW, as many rows as it takes, 1
    uint count;
    uint pixels[];  // x + 65536 y
};
shared uint tile_count, tile_first;

// Of 64 pixels each. A device takes 65,535 along x at least, so they are laid in rows; those behind the end are idle.
const uint GROUPS_OF_A_ROW = 16u;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy) + ivec2(0, band.x);
    ivec2 last = ivec2(textureSize(covered_depth, 0).x, band.y) - 1;
    if (gl_LocalInvocationIndex == 0u) tile_count = 0u;
    barrier();
    bool covered = all(lessThanEqual(pixel, last)) && texelFetch(covered_depth, min(pixel, last), 0).r < 1.0;
    uint at = 0u;
    if (covered) at = atomicAdd(tile_count, 1u);
    barrier();
    if (gl_LocalInvocationIndex == 0u && tile_count > 0u) {
        tile_first = atomicAdd(count, tile_count);
        uint row = 64u * GROUPS_OF_A_ROW;
        atomicMax(groups.y, (tile_first + tile_count + row - 1u) / row);
    }
    barrier();
    if (covered) pixels[tile_first + at] = uint(pixel.x) | uint(pixel.y) << 16;
}
