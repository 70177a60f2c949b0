#version 430
// Vertices of the cloth to the G-buffer.
in vec3 in_position;
in vec3 in_normal;
in vec4 in_tangent;  // x axis of the surface frame (yarn 1), and the handedness of the UVs
uniform mat4 clip_from_world;
out vec3 position;
out vec3 normal;
out vec3 tangent;
flat out float handedness;

void main() {
    position = in_position;
    normal = in_normal;
    tangent = in_tangent.xyz;
    handedness = in_tangent.w;
    gl_Position = clip_from_world * vec4(in_position, 1.0);
}
