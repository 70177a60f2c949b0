#version 430
// Points, lines and triangles in one colour each vertex, for the view of the tree.
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 vertex_color;
uniform mat4 clip_from_world;
uniform float nearer;  // draws lines a little before the surface they lie on
out vec3 plain_color;

void main() {
    plain_color = vertex_color;
    gl_Position = clip_from_world * vec4(position, 1.0);
    gl_Position.z -= nearer * gl_Position.w;
}
