#version 430
// Rays to the lamp from the middles of some triangles of the curtain, and the light that arrives if nothing is on their way:
// the irradiance of the side that faces the lamp.
layout(local_size_x = 64) in;
#include "inputs/gpu/item.glsl"
uniform usamplerBuffer corner_data;  // three texels a triangle: x, y, z, packed normal
uniform usamplerBuffer chosen;       // triangles
layout(std430) writeonly buffer Points { vec4 points[]; };
layout(std430) writeonly buffer Lights { vec4 lights[]; };
uniform int chosen_count;
uniform int first;         // where they are written
uniform vec3 lamp;         // its position
uniform vec3 intensity;    // W/sr
uniform float offset;      // how far off the surface rays begin

void main() {
    int i = item();
    if (i >= chosen_count) return;
    int triangle = int(texelFetch(chosen, i).x);
    vec3 a = uintBitsToFloat(texelFetch(corner_data, 3 * triangle).xyz);
    vec3 b = uintBitsToFloat(texelFetch(corner_data, 3 * triangle + 1).xyz);
    vec3 c = uintBitsToFloat(texelFetch(corner_data, 3 * triangle + 2).xyz);
    vec3 n = cross(b - a, c - a);
    n *= inversesqrt(max(dot(n, n), 1e-30));
    vec3 p = (a + b + c) / 3.0;
    vec3 l = lamp - p;
    float distance_2 = max(dot(l, l), 1e-12);
    float cosine = dot(n, l) * inversesqrt(distance_2);
    points[first + i] = vec4(p + (cosine < 0.0 ? -offset : offset) * n, 0.0);
    lights[first + i] = vec4(abs(cosine) * intensity / distance_2, 0.0);
}
