#version 430
// Points, lines and triangles in one colour each vertex, for the view of the tree.
uniform samplerBuffer vertices;  // two texels: position, colour
uniform mat4 clip_from_world;
uniform float nearer;            // draws lines a little before the surface they lie on
out vec3 plain_color;

void main() {
    plain_color = texelFetch(vertices, 2 * gl_VertexID + 1).rgb;
    gl_Position = clip_from_world * vec4(texelFetch(vertices, 2 * gl_VertexID).xyz, 1.0);
    gl_Position.z -= nearer * gl_Position.w;
}
