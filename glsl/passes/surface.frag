#version 430
// The surface frame of every covered pixel, turned toward the viewer: N and the x axis, with the handedness.
#include "core/shading_frame.glsl"
in vec3 position;
in vec3 normal;
in vec3 tangent;
flat in float handedness;
uniform vec3 eye;
layout(location = 0) out vec4 frame_N;  // N, and 1 or -1: the handedness of (x, y, N); 0 where nothing is drawn
layout(location = 1) out vec4 frame_x;  // x, and the side of the sheet that is seen: 1 front, -1 back

void main() {
    vec3 omega_o = normalize(eye - position);
    float side = gl_FrontFacing ? 1.0 : -1.0;
    // The triangle's own cosine is the least that is true. Where even that is below 0.1 the smooth normal may stop at it;
    // a fold's rim beyond 0.1 is thinner than a pixel for any fold of less than 200 pixels' radius.
    vec3 flat_normal = normalize(cross(dFdx(position), dFdy(position)));
    float least = clamp(abs(dot(flat_normal, omega_o)), 0.02, 0.1);
    vec3 N = facing_normal(normalize(normal) * side, omega_o, least);
    // Seen from behind, x stays and y stays: (x, y, -N) has the other handedness.
    frame_N = vec4(N, handedness * side);
    frame_x = vec4(orthogonal_part(tangent, N), side);
}
