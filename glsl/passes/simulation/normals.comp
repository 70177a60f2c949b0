#version 430
// Smooth normals and yarn-1 directions of the grid by central differences (one-sided at the border). One invocation
// per vertex. Rows run down yarn 2 (v falls), columns along yarn 1 (u grows).
layout(local_size_x = 64) in;
#include "inputs/gpu/item.glsl"
uniform samplerBuffer Position;
layout(std430) writeonly buffer Normal { vec4 normal[]; };
layout(std430) writeonly buffer Tangent { vec4 tangent[]; };
uniform int rows;
uniform int columns;

void main() {
    int index = item();
    if (index >= rows * columns) {
        return;
    }
    int i = index / columns;
    int j = index - i * columns;
    int row = i * columns;
    vec3 along_u = texelFetch(Position, row + min(j + 1, columns - 1)).xyz - texelFetch(Position, row + max(j - 1, 0)).xyz;
    vec3 along_v = texelFetch(Position, max(i - 1, 0) * columns + j).xyz
                 - texelFetch(Position, min(i + 1, rows - 1) * columns + j).xyz;
    vec3 N = cross(along_u, along_v);
    float l = length(N);
    N = l > 0.0 ? N / l : vec3(0.0, 0.0, 1.0);
    vec3 t = along_u - dot(along_u, N) * N;
    float m = length(t);
    normal[index] = vec4(N, 0.0);
    tangent[index] = vec4(m > 0.0 ? t / m : vec3(1.0, 0.0, 0.0), 1.0);
}
