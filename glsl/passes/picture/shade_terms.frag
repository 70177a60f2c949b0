#version 430
// Shades every second pixel of every second row as cloth from afar, and keeps what each tangent adds to it.   [own]
#include "method.glsl"
#include "seen.glsl"
#include "inputs/picture/gbuffer.glsl"
layout(early_fragment_tests) in;  // a shader that writes to an image is tested late otherwise
layout(rgba32f) writeonly uniform image2DArray terms;  // GROUPS each of surface terms, volume terms, leans; then `light_texels`
out vec4 color;

void main() {
    ivec2 at = ivec2(gl_FragCoord.xy), pixel = min(2 * at, textureSize(frame_N, 0) - 1);
    mat3 surface_from_world = surface_from_world_at(pixel);
    vec3 omega_o = surface_from_world * omega_o_at(vec2(pixel) + 0.5);
    fetch_visibility(pixel);
    vec3 L = L_o(vec3(omega_o.xy, max(omega_o.z, 1e-4)), surface_from_world);
    color = vec4(with_bounce(L), 1.0);
#define STORE_TERMS(g) imageStore(terms, ivec3(at, g), term_s[g]); imageStore(terms, ivec3(at, g + GROUPS), term_v[g]); \
    imageStore(terms, ivec3(at, g + 2 * GROUPS), side_texel(g));
    EACH_GROUP(STORE_TERMS)
    mat3x4 light = light_texels();
    imageStore(terms, ivec3(at, 3 * GROUPS), light[0]);
    imageStore(terms, ivec3(at, 3 * GROUPS + 1), light[1]);
    imageStore(terms, ivec3(at, 3 * GROUPS + 2), light[2]);
}
