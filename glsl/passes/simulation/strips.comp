#version 430
// Shear: both diagonals of every quad. One invocation per strip of quads between two rows; only even or only odd
// strips in one dispatch, which share no vertex.
#include "simulate/constraint.glsl"
layout(local_size_x = 8) in;
#include "inputs/gpu/item.glsl"
layout(std430) buffer Position { vec4 x[]; };
uniform int rows;
uniform int columns;
uniform int parity;
uniform int backward;
uniform float rest;       // m, length of a diagonal
uniform float shear_h2;   // compliance / h^2, 1/kg

void main() {
    int i = 2 * item() + parity;
    if (i >= rows - 1) {
        return;
    }
    int upper = i * columns + backward * (columns - 1);
    int hop = backward == 1 ? -1 : 1;
    vec4 a = x[upper];
    vec4 c = x[upper + columns];
    for (int k = 1; k < columns; k++) {
        vec4 b = x[upper + hop];
        vec4 d = x[upper + hop + columns];
        vec3 lambda = lambda_stretch(a.xyz, d.xyz, a.w, d.w, rest, shear_h2);
        a.xyz -= a.w * lambda;
        d.xyz += d.w * lambda;
        lambda = lambda_stretch(b.xyz, c.xyz, b.w, c.w, rest, shear_h2);
        b.xyz -= b.w * lambda;
        c.xyz += c.w * lambda;
        x[upper] = a;
        x[upper + columns] = c;
        upper += hop;
        a = b;
        c = d;
    }
    x[upper] = a;
    x[upper + columns] = c;
}
