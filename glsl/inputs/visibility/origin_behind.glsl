// Where rays of a pixel start on the side of the cloth that looks away from the viewer: what passes/picture/surface.frag
// finds for the side that is seen.
#include "core/origin.glsl"
#include "inputs/picture/gbuffer_point.glsl"
#include "inputs/visibility/drawn.glsl"
const float OFFSET_BEHIND = 0.02;      // of the triangle's size

vec3 origin_behind(ivec2 pixel) {
    int first = 3 * triangle_at(pixel);
    ivec3 at = 3 * ivec3(texelFetch(drawn_corners, first).x, texelFetch(drawn_corners, first + 1).x,
        texelFetch(drawn_corners, first + 2).x);
    float side = -texelFetch(frame_x, pixel, 0).w;
    vec4 p_a = texelFetch(drawn_vertices, at.x), q_a = texelFetch(drawn_vertices, at.x + 1);
    vec4 p_b = texelFetch(drawn_vertices, at.y), q_b = texelFetch(drawn_vertices, at.y + 1);
    vec4 p_c = texelFetch(drawn_vertices, at.z), q_c = texelFetch(drawn_vertices, at.z + 1);
    vec3 n_a = side * q_a.xyz, n_b = side * q_b.xyz, n_c = side * q_c.xyz;
    vec3 w = weights_at(pixel);
    vec3 x = w.x * p_a.xyz + w.y * p_b.xyz + w.z * p_c.xyz;
    vec3 across = side * cross(p_b.xyz - p_a.xyz, p_c.xyz - p_a.xyz);
    float area_2 = length(across);
    vec3 step_off = area_2 > 0.0 ? OFFSET_BEHIND * inversesqrt(area_2) * across : vec3(0.0);
    vec3 lift = side > 0.0 ? vec3(p_a.w, p_b.w, p_c.w) : vec3(q_a.w, q_b.w, q_c.w);
    step_off += dot(w, lift) * normalize(w.x * n_a + w.y * n_b + w.z * n_c);
    return lifted(x, w, p_a.xyz, p_b.xyz, p_c.xyz, n_a, n_b, n_c) + step_off;
}
