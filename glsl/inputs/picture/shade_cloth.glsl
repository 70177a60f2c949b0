// A pixel of cloth, shaded with the method that is included as "method.glsl".
#include "inputs/picture/output.glsl"
#ifdef PARTS
#include "inputs/picture/parts.glsl"
#endif
#include "method.glsl"
#include "seen.glsl"
#include "inputs/picture/gbuffer.glsl"
uniform float pass_weight;  // share of this sample in the pixel
uniform float pass_cover;   // what this pass adds to the pixel's coverage: the first all
uniform int pixel_stride = 1;  // 2: this picture is that of every second pixel of every second row

void shade(ivec2 at) {
    ivec2 pixel = shaded_pixel = min(at * pixel_stride, textureSize(frame_N, 0) - 1);
    mat3 surface_from_world = surface_from_world_at(pixel);
    vec3 omega_o = surface_from_world * omega_o_at(vec2(pixel) + 0.5);
    fetch_visibility(pixel);
#ifdef WEAVE
    fetch_weave(pixel);
#endif
    vec3 L = L_o(vec3(omega_o.xy, max(omega_o.z, 1e-4)), surface_from_world);
    color = vec4(with_bounce(L) * pass_weight, pass_cover);
#ifdef PARTS
    bounce_color = vec4((L_bounce + (with_bounce(L) - L)) * pass_weight, 0.0);
    through_color = vec4(0.0);
#endif
}
