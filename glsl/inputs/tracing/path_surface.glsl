// What a ray of the path tracer meets: the frame and the material of a point, and where rays from it start.
// glcloth/tracing/path.py fills the buffers; the cloths come first, then the objects; the ground is a plane.
#include "core/math.glsl"
#include "core/origin.glsl"
#include "core/shading_frame.glsl"
#include "trace/ground.glsl"
#ifndef SHEER
uniform isamplerBuffer hit_corners;  // three a triangle, in the order that hits are weighted in
uniform samplerBuffer hit_vertices;  // three texels a vertex: position, normal, tangent with the handedness
#endif
uniform samplerBuffer solid_data;    // of each triangle of the objects what it reflects, its picture; then of the ground
#ifdef PICTURES
uniform sampler2DArray surface_pictures;  // the first row at v = 0
uniform usamplerBuffer mask_words;   // of all fabric masks, row by row: a byte a texel, the fabric of the cloth
uniform int mask_stride;             // words a row
#endif
#if defined(PICTURES) || defined(WEAVE)
uniform samplerBuffer surface_uv;    // of each vertex
#endif
uniform samplerBuffer cloth_data;    // CLOTH_TEXELS a cloth, see inputs/tracing/path_fabric.glsl
uniform int cloth_count;
uniform int cloth_triangles;         // of all cloths; the objects' follow
uniform int solid_triangles;

const int CLOTH_TEXELS = 8;
const float OFFSET = 0.02;           // of the triangle's size: how far rays start from it
const float FLAT_OFFSET = 2e-5;      // of a flat one, of the distance from the origin
const float GROUND_OFFSET = 1e-5;    // of the distance

float most(vec3 v) { return max(v.r, max(v.g, v.b)); }

struct Point {
    int cloth;        // -1: it is matt
    vec3 reflectance;
    mat3 frame;       // columns x, y, N, toward where the ray comes from
    vec3 N_g;         // of the triangle, likewise
    vec3 origin;      // of rays on that side,
    vec3 behind;      // and on the other one
};

int cloth_of(int triangle) {
    int c = 0;
    while (c + 1 < cloth_count && float(triangle) >= texelFetch(cloth_data, CLOTH_TEXELS * c + 2).w) ++c;
    return c;
}

Point ground_point(vec3 o, vec3 d, float t) {
    vec3 N = vec3(0.0, d.y < 0.0 ? 1.0 : -1.0, 0.0);
    vec3 x = vec3(1.0, 0.0, 0.0), p = o + t * d;
    float off = GROUND_OFFSET * (1.0 + t);
    // From below the ground is black.
    vec3 color = d.y < 0.0 ? texelFetch(solid_data, solid_triangles).rgb : vec3(0.0);
    return Point(-1, color, mat3(x, cross(N, x), N), N, p + off * N, p - off * N);
}

#ifdef PICTURES
vec2 uv_at(int triangle, vec2 at) {
    vec2 a = texelFetch(surface_uv, texelFetch(hit_corners, 3 * triangle).x).xy;
    vec2 b = texelFetch(surface_uv, texelFetch(hit_corners, 3 * triangle + 1).x).xy;
    vec2 c = texelFetch(surface_uv, texelFetch(hit_corners, 3 * triangle + 2).x).xy;
    return (1.0 - at.x - at.y) * a + at.x * b + at.y * c;
}

// A picture at a place; without one (-1) white. A pixel's samples are its filter.
vec3 picture_at(float number, vec2 at) {
    return number < 0.0 ? vec3(1.0) : textureLod(surface_pictures, vec3(at, number), 0.0).rgb;
}

// How much of a place is closed by cloth.
float closed_at(int cloth, vec2 uv) {
    vec4 maps = texelFetch(cloth_data, CLOTH_TEXELS * cloth + 5), repeats = texelFetch(cloth_data, CLOTH_TEXELS * cloth + 6);
    return picture_at(maps.w, uv * repeats.zw).r;
}

// Which of the fabrics of a mask a place has, counted from the cloth's first one; 0 without a mask.
int fabric_at(int cloth, vec2 uv) {
    float first = texelFetch(cloth_data, CLOTH_TEXELS * cloth + 4).w;
    if (first < 0.0) return 0;
    vec4 mask = texelFetch(cloth_data, CLOTH_TEXELS * cloth + 7);
    // By whole texels, as passes/picture/surface.frag.
    ivec2 texel = min(ivec2(fract(uv * mask.zw) * mask.xy), ivec2(mask.xy) - 1);
    uint word = texelFetch(mask_words, mask_stride * (int(first) + texel.y) + texel.x / 4).x;
    return int(word >> uint(8 * (texel.x & 3)) & 255u);
}

// What the colours of its yarns are multiplied by.
vec3 printed_at(int cloth, vec2 uv) {
    vec4 maps = texelFetch(cloth_data, CLOTH_TEXELS * cloth + 5), repeats = texelFetch(cloth_data, CLOTH_TEXELS * cloth + 6);
    return picture_at(maps.z, uv * repeats.xy);
}
#endif

// The point where a ray along d meets a triangle.
Point point_at(int triangle, vec2 at, vec3 d) {
    ivec3 v = 3 * ivec3(texelFetch(hit_corners, 3 * triangle).x, texelFetch(hit_corners, 3 * triangle + 1).x,
        texelFetch(hit_corners, 3 * triangle + 2).x);
    vec3 w = vec3(1.0 - at.x - at.y, at);
    vec3 a = texelFetch(hit_vertices, v.x).xyz, b = texelFetch(hit_vertices, v.y).xyz, c = texelFetch(hit_vertices, v.z).xyz;
    vec3 across = cross(b - a, c - a);
    float side = dot(across, d) > 0.0 ? -1.0 : 1.0;
    vec3 n_a = side * texelFetch(hit_vertices, v.x + 1).xyz, n_b = side * texelFetch(hit_vertices, v.y + 1).xyz;
    vec3 n_c = side * texelFetch(hit_vertices, v.z + 1).xyz;
    vec4 x_a = texelFetch(hit_vertices, v.x + 2);
    vec3 x = w.x * x_a.xyz + w.y * texelFetch(hit_vertices, v.y + 2).xyz + w.z * texelFetch(hit_vertices, v.z + 2).xyz;
    float area_2 = max(length(across), 1e-30);
    vec3 N_g = side * across / area_2;
    // As passes/picture/surface.frag bends it.
    vec3 N = facing_normal(normalize(w.x * n_a + w.y * n_b + w.z * n_c), -d, clamp(-dot(N_g, d), 0.02, 0.1));
    x = orthogonal_part(x, N);
    vec3 p = w.x * a + w.y * b + w.z * c;
    float apart = OFFSET * sqrt(area_2);
    // A wall of two triangles is no curved surface, and light comes close to it.
    if (min(dot(n_a, n_b), dot(n_b, n_c)) > 0.999999) apart = min(apart, FLAT_OFFSET * (1.0 + most(abs(p))));
    vec3 off = apart * N_g;
    bool cloth = triangle < cloth_triangles;
    vec3 reflectance = cloth ? vec3(0.0) : texelFetch(solid_data, triangle - cloth_triangles).rgb;
    // Seen from behind, x stays and y stays: (x, y, -N) has the other handedness.
    return Point(cloth ? cloth_of(triangle) : -1, reflectance, mat3(x, side * x_a.w * cross(N, x), N), N_g,
        lifted(p, w, a, b, c, n_a, n_b, n_c) + off, lifted(p, w, a, b, c, -n_a, -n_b, -n_c) - off);
}
