#version 430
// Triangles of cloth cut into four, some times, along the curved surface that their corners' normals tell of: what hides the
// suns, for the shadow of a flat triangle's edge is a saw's tooth. Those of other things stay as they are.   [own, docs/shadows.md]
#include "inputs/visibility/cut.glsl"
layout(local_size_x = 64) in;
#include "inputs/gpu/item.glsl"
uniform isamplerBuffer corner_index;  // three a triangle
uniform samplerBuffer vertex_data;    // three texels a vertex: position, normal, tangent
layout(std430) writeonly buffer Corners { uvec4 corner[]; };  // three a triangle
uniform int finer_levels;
uniform int finer_triangles;          // so many, from the first on, are cut
uniform int triangle_count;           // when it is done
const float THIN = 2e-6;              // as without_lines of glcloth/accel/triangles.py

void main() {
    int i = item();
    if (i >= triangle_count) return;
    int whole = finer_triangles << (2 * finer_levels);
    int t = 3 * (i < whole ? i >> (2 * finer_levels) : finer_triangles + i - whole);
    ivec3 v = 3 * ivec3(texelFetch(corner_index, t).x, texelFetch(corner_index, t + 1).x, texelFetch(corner_index, t + 2).x);
    Smooth s = Smooth(texelFetch(vertex_data, v.x).xyz, texelFetch(vertex_data, v.y).xyz, texelFetch(vertex_data, v.z).xyz,
        texelFetch(vertex_data, v.x + 1).xyz, texelFetch(vertex_data, v.y + 1).xyz, texelFetch(vertex_data, v.z + 1).xyz);
    int level = i < whole ? finer_levels : 0;
    while (level-- > 0) s = part_of(s, i >> (2 * level) & 3);
    vec3 e = s.b - s.a, f = s.c - s.a, g = s.c - s.b;
    float longest = max(dot(e, e), max(dot(f, f), dot(g, g)));
    if (length(cross(e, f)) <= THIN * longest) s.b = s.c = s.a;
    corner[3 * i] = uvec4(floatBitsToUint(s.a), 0u);
    corner[3 * i + 1] = uvec4(floatBitsToUint(s.b), 0u);
    corner[3 * i + 2] = uvec4(floatBitsToUint(s.c), 0u);
}
