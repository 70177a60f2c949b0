// A pixel of a coarse picture, shaded as cloth from afar; what each tangent adds to it is kept.   [own]
#include "inputs/picture/output.glsl"
#ifndef COVERED
layout(early_fragment_tests) in;  // a shader that writes to an image is tested late otherwise
#endif
#include "method.glsl"
#include "seen.glsl"
#include "inputs/picture/gbuffer.glsl"
// GROUPS layers each of surface terms' luminance, red, blue, of volume terms', of how far they lean; then how far colours do, and bounced light.
layout(rgba16f) writeonly uniform image2DArray terms;
uniform int terms_row;     // that of the coarse picture's first row
uniform int terms_stride;  // pixels from one of the coarse picture to the next

void store(ivec2 at, int layer, mat3x4 texels) {
    for (int i = 0; i < 3; ++i) imageStore(terms, ivec3(at, layer + i * GROUPS), texels[i]);
}

void shade(ivec2 at) {
    ivec2 pixel = shaded_pixel = min(terms_stride * at, textureSize(frame_N, 0) - 1);
    mat3 surface_from_world = surface_from_world_at(pixel);
    vec3 omega_o = surface_from_world * omega_o_at(vec2(pixel) + 0.5);
    fetch_visibility(pixel);
    vec3 L = L_o(vec3(omega_o.xy, max(omega_o.z, 1e-4)), surface_from_world);
    vec3 bounce = with_bounce(L) - L;
    color = vec4(L + bounce, 1.0);
    at.y += terms_row;
#define STORE_TERMS(g) store(at, g, term_texels(term_s[g])); store(at, g + 3 * GROUPS, term_texels(term_v[g])); \
    imageStore(terms, ivec3(at, g + 6 * GROUPS), side_texel(g));
    EACH_GROUP(STORE_TERMS)
    imageStore(terms, ivec3(at, 7 * GROUPS), side_color_texel());
    imageStore(terms, ivec3(at, 7 * GROUPS + 1), vec4(term_scale * bounce, 0.0));
}
