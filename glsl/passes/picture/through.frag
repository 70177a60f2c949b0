#version 430
// Adds what comes through cloth from its other side, but for what goes straight on.   [own]
#include "core/math.glsl"
#ifdef PARTS
#include "inputs/picture/parts.glsl"
#endif
#include "inputs/picture/straight.glsl"
#include "inputs/picture/gbuffer.glsl"
#include "inputs/picture/gbuffer_point.glsl"
#include "behind.glsl"
// Last: a file that is first included where PRINT is not defined would be left out below.
#ifdef PRINT
#include "inputs/picture/print.glsl"
#endif
uniform float pass_weight;  // share of this sample in the pixel
layout(location = 0) out vec4 color;

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    mat3 surface_from_world = surface_from_world_at(pixel);
    vec3 omega_o = surface_from_world * omega_o_at(vec2(pixel) + 0.5);
    vec3 L = L_behind(pixel, vec3(omega_o.xy, max(omega_o.z, 1e-4)), surface_from_world);
#ifdef PRINT
    L *= min(print_mean * print_over_mean(pixel_uv(pixel)), vec3(1.0));
#endif
    color = vec4(L * (pass_weight * yarns_at(pixel)), 0.0);
#ifdef PARTS
    bounce_color = vec4(0.0);
    through_color = color;
#endif
}
