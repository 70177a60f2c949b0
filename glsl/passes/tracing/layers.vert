#version 430
// The corners of the triangle soup in a given order of triangles, for the rasterised picture.
uniform usamplerBuffer corner_data;
uniform usamplerBuffer order;
uniform mat4 clip_from_world;
out vec3 p;
out vec3 weights;         // barycentric
flat out int triangle;

void main() {
    triangle = int(texelFetch(order, gl_VertexID / 3).x);
    int k = gl_VertexID % 3;
    p = uintBitsToFloat(texelFetch(corner_data, 3 * triangle + k).xyz);
    weights = vec3(k == 0, k == 1, k == 2);
    gl_Position = clip_from_world * vec4(p, 1.0);
}
