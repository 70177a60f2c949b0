#version 430
// Shades the covered pixels of a picture by what is included as "shade.glsl", as a draw of covered.frag does.   [own]
#define COVERED 1
#include "shade.glsl"
layout(local_size_x = 64) in;
#include "inputs/gpu/item.glsl"
layout(std430) readonly buffer Covered {
    uvec3 groups;  // of passes/picture/covered_list.comp
    uint count;
    uint pixels[];  // x + 65536 y
};
uniform bool adds;  // to the present picture
layout(rgba32f) uniform image2D target_color;
#ifdef PARTS
layout(rgba32f) uniform image2D target_bounce;
layout(rgba32f) uniform image2D target_through;
#endif

void main() {
    // Invocations behind the end shade the last pixel again, which costs less than a branch, and keep nothing.
    uint i = uint(item());
    uint packed_pixel = pixels[min(i, count - 1u)];
    ivec2 pixel = ivec2(packed_pixel & 0xffffu, packed_pixel >> 16);
    shade(pixel);
    if (i >= count) return;
    imageStore(target_color, pixel, adds ? imageLoad(target_color, pixel) + color : color);
#ifdef PARTS
    imageStore(target_bounce, pixel, adds ? imageLoad(target_bounce, pixel) + bounce_color : bounce_color);
    imageStore(target_through, pixel, adds ? imageLoad(target_through, pixel) + through_color : through_color);
#endif
}
