#version 430
// Bending, then stretch, along the rows, or along the columns. One invocation per line: lines share no vertex, so there
// is no race; along its line an invocation goes there and back with the last vertices in registers. On the way there it
// bends (Gauss-Seidel, in a direction that alternates between substeps) and eliminates the edges two vertices behind;
// on the way back it moves the vertices by the exact solution of all the line's edges.
#include "simulate/constraint.glsl"
layout(local_size_x = 8) in;
#include "inputs/gpu/item.glsl"
layout(std430) buffer Position { vec4 x[]; };
layout(std430) buffer Eliminated { vec2 eliminated[]; };   // pivot and d of the edge before each vertex
uniform int lines;
uniform int count;          // vertices in a line, >= 3
uniform int line_stride;
uniform int stride;
uniform int backward;       // 1 = begin at the far end
uniform float rest;         // m
uniform float stretch_h2;   // compliance / h^2, 1/kg, of a line inside the cloth
uniform float bend_h2;

// Edge from vertex a to b: unit direction and length; a collapsed edge keeps some direction, so that it can open again.
vec4 edge(vec3 a, vec3 b) {
    vec3 e = b - a;
    float l = length(e);
    return vec4(l > 0.0 ? e / l : vec3(0.0, 1.0, 0.0), l);
}

void main() {
    int line = item();
    if (line >= lines) {
        return;
    }
    // The first and the last line stand for half the width, hence half the stiffness.
    float give = line == 0 || line == lines - 1 ? 2.0 : 1.0;
    int first = line * line_stride + backward * (count - 1) * stride;
    int hop = backward == 1 ? -stride : stride;
    vec4 z = vec4(0.0);       // vertex k - 3, already bent
    vec4 a = x[first];        // vertex k - 2
    vec4 b = x[first + hop];  // vertex k - 1
    vec3 n = vec3(0.0);       // direction of the edge before z
    vec2 done = vec2(1.0, 0.0);
    // Two rounds more than vertices to bend: the last two have no vertex ahead, but edges to eliminate.
    for (int k = 2; k < count + 2; k++) {
        vec4 c = x[first + min(k, count - 1) * hop];
        if (k < count) {
            vec3 lambda = lambda_bend(a.xyz, b.xyz, c.xyz, a.w, b.w, c.w, give * bend_h2);
            a.xyz += a.w * lambda;
            b.xyz -= 2.0 * b.w * lambda;
            c.xyz += c.w * lambda;
        }
        if (k > 2) {
            vec4 e = edge(z.xyz, a.xyz);
            done = eliminate(z.w + a.w + give * stretch_h2, -z.w * dot(n, e.xyz), e.w - rest, done);
            eliminated[first + (k - 2) * hop] = done;
            n = e.xyz;
        }
        x[first + (k - 2) * hop] = a;
        z = a;
        a = b;
        b = c;
    }
    // z is the last vertex now.
    vec3 pull = vec3(0.0);    // n lambda of the edge after vertex b
    float lambda = 0.0;
    n = vec3(0.0);
    b = z;
    for (int k = count - 2; k >= 0; k--) {
        a = x[first + k * hop];
        vec4 e = edge(a.xyz, b.xyz);
        lambda = substitute(eliminated[first + (k + 1) * hop], -b.w * dot(n, e.xyz), lambda);
        n = e.xyz;
        x[first + (k + 1) * hop] = vec4(b.xyz + b.w * (n * lambda - pull), b.w);
        pull = n * lambda;
        b = a;
    }
    x[first] = vec4(b.xyz - b.w * pull, b.w);
}
