// The surface that a hit lies on: corners, smooth normal and yarn direction of the triangle, and its material.
#include "core/shading_frame.glsl"
#include "trace/octahedron.glsl"

uniform usamplerBuffer corner_data;     // three texels a triangle: x, y, z, packed normal
uniform usamplerBuffer attribute_data;  // one texel: material, packed x axis of each corner
uniform samplerBuffer material_data;    // one texel: diffuse reflectance, 1 if it is cloth

struct Surface {
    vec3 N_g;     // geometric normal, toward the viewer
    vec3 N;       // smooth normal, toward the viewer
    vec3 x;       // yarn 1, perpendicular to N
    vec3 diffuse;
    bool cloth;
};

vec3 unpacked(uint packed_direction) { return from_octahedral(unpackSnorm2x16(packed_direction)); }

Surface surface_at(int triangle, vec2 weights, vec3 omega_o) {
    uvec4 a = texelFetch(corner_data, 3 * triangle);
    uvec4 b = texelFetch(corner_data, 3 * triangle + 1);
    uvec4 c = texelFetch(corner_data, 3 * triangle + 2);
    uvec4 attributes = texelFetch(attribute_data, triangle);
    vec4 material = texelFetch(material_data, int(attributes.x));
    vec3 A = uintBitsToFloat(a.xyz);
    vec3 N_g = normalize(cross(uintBitsToFloat(b.xyz) - A, uintBitsToFloat(c.xyz) - A));
    float first = 1.0 - weights.x - weights.y;
    vec3 N = first * unpacked(a.w) + weights.x * unpacked(b.w) + weights.y * unpacked(c.w);
    vec3 x = first * unpacked(attributes.y) + weights.x * unpacked(attributes.z) + weights.y * unpacked(attributes.w);
    if (dot(N_g, omega_o) < 0.0) N_g = -N_g;
    if (dot(N, N_g) < 0.0) N = -N;
    N = facing_normal(normalize(N), omega_o, 0.02);
    return Surface(N_g, N, orthogonal_part(x, N), material.rgb, material.w > 0.5);
}
