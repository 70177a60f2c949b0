#version 430
// Shades the covered pixels with the method that is included as "method.glsl".
#include "method.glsl"
#include "passes/gbuffer.glsl"
uniform float pass_weight;  // share of this sample in the pixel
uniform float pass_cover;   // what this pass adds to the pixel's coverage
out vec4 color;

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    mat3 surface_from_world = surface_from_world_at(pixel);
    vec3 omega_o = surface_from_world * omega_o_at(gl_FragCoord.xy);
    vec3 L = L_o(vec3(omega_o.xy, max(omega_o.z, 1e-4)), surface_from_world);
    color = vec4(L * pass_weight, pass_cover);
}
