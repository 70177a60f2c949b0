#version 430
// How much of the light behind a layer of cloth comes to the viewer.
#include "inputs/picture/straight.glsl"
#include "inputs/picture/gbuffer.glsl"
uniform sampler2D left;   // of the light of the layer itself
uniform bool first;       // all of it
out vec4 color;

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    if (texelFetch(frame_N, pixel, 0).w == 0.0) discard;
    vec3 omega_o = surface_from_world_at(pixel) * omega_o_at(vec2(pixel) + 0.5);
    vec3 before = first ? vec3(1.0) : texelFetch(left, pixel, 0).rgb;
    color = vec4(before * T_s_at(pixel, vec3(omega_o.xy, max(omega_o.z, 1e-4))), 0.0);
}
