#version 430
// Shades the pixels of a list with the method that is included as "method.glsl".
#include "method.glsl"
#include "seen.glsl"
#include "inputs/picture/gbuffer.glsl"

layout(local_size_x = 64) in;
layout(std430) readonly buffer Pixels {
    uvec3 groups;  // of 64 pixels: the arguments of this dispatch
    uint count;
    uint pixels[];  // x + 65536 y
};
uniform uint first;  // where in the list this dispatch begins
layout(rgba32f) writeonly uniform image2D color;

void main() {
    uint i = first + gl_GlobalInvocationID.x;
    // Invocations behind the end repeat the last pixel: a value that is written twice costs less than a branch.
    uint packed_pixel = pixels[min(i, count - 1u)];
    ivec2 pixel = ivec2(packed_pixel & 0xffffu, packed_pixel >> 16);
    mat3 surface_from_world = surface_from_world_at(pixel);
    vec3 omega_o = surface_from_world * omega_o_at(vec2(pixel) + 0.5);
    fetch_visibility(pixel);
#ifdef WEAVE
    fetch_weave(pixel);
#endif
    vec3 L = L_o(vec3(omega_o.xy, max(omega_o.z, 1e-4)), surface_from_world);
    imageStore(color, pixel, vec4(with_bounce(L), 1.0));
}
