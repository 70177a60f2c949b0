#version 430
// The surface frame of every covered pixel, turned toward the viewer: N and the x axis, with the handedness; and where
// on which triangle it lies.
#include "core/origin.glsl"
#include "core/shading_frame.glsl"
in vec3 position;
in vec3 normal;
in vec3 tangent;
flat in float handedness;
uniform vec4 viewpoint;  // (eye, 1), or of parallel rays (direction toward the camera, 0)
uniform samplerBuffer vertex_data;   // three texels a vertex: position and normal, each with a lift; tangent
uniform isamplerBuffer corner_index;  // three a triangle
uniform isamplerBuffer triangle_number;  // of each that is drawn: all, or those of a band
#ifdef AMONG_OTHERS
uniform sampler2D nearer;  // the depth of what was drawn before
uniform bool hidden_by_others;
uniform int one_sided_from;   // from this triangle on only the front is drawn
#endif
#ifdef BEHIND
uniform sampler2D behind;     // the depth of cloth that lets light through: only what is behind it is drawn
#endif
#ifdef CUT_OUT
uniform samplerBuffer cut_uv;  // of each vertex
#endif
#ifdef OPENINGS
uniform sampler2DArray opacity_map;
uniform vec2 opacity_repeats;
uniform float opacity_threshold;  // of this sample: where the map has less, there is no cloth
#endif
#ifdef FABRIC_MASK
uniform usampler2D mask_map;      // the number of a fabric
uniform vec2 mask_repeats;
uniform int mask_number;          // of this cloth: where the mask has another, there is another cloth
#endif
layout(location = 0) out vec4 frame_N;  // N, and 1 or -1: the handedness of (x, y, N); 0 where nothing is drawn
layout(location = 1) out vec4 frame_x;  // x, and the side of the sheet that is seen: 1 front, -1 back
layout(location = 2) out vec4 frame_p;  // where rays start, world; the number of the triangle
layout(location = 3) out vec2 frame_b;  // barycentric coordinates of the triangle's second and third corner

const float BEHIND_STEP = 4e-7;  // of the depth: some steps of its 24 bits
const float OFFSET = 0.02;  // of the triangle's size: how far rays start from it

void main() {
    vec3 omega_o = normalize(viewpoint.xyz - viewpoint.w * position);
    float side = gl_FrontFacing ? 1.0 : -1.0;
    // The triangle's own cosine is the least that is true. Where even that is below 0.1 the smooth normal may stop at it;
    // a fold's rim beyond 0.1 is thinner than a pixel for any fold of less than 200 pixels' radius.
    vec3 flat_normal = normalize(cross(dFdx(position), dFdy(position)));
    float least = clamp(abs(dot(flat_normal, omega_o)), 0.02, 0.1);
    vec3 N = facing_normal(normalize(normal) * side, omega_o, least);
    // Seen from behind, x stays and y stays: (x, y, -N) has the other handedness.
    frame_N = vec4(N, handedness * side);
    frame_x = vec4(orthogonal_part(tangent, N), side);

    int number = texelFetch(triangle_number, gl_PrimitiveID).x;
    ivec3 corners = ivec3(texelFetch(corner_index, 3 * number).x, texelFetch(corner_index, 3 * number + 1).x,
        texelFetch(corner_index, 3 * number + 2).x);
    vec4 p_a = texelFetch(vertex_data, 3 * corners.x), q_a = texelFetch(vertex_data, 3 * corners.x + 1);
    vec4 p_b = texelFetch(vertex_data, 3 * corners.y), q_b = texelFetch(vertex_data, 3 * corners.y + 1);
    vec4 p_c = texelFetch(vertex_data, 3 * corners.z), q_c = texelFetch(vertex_data, 3 * corners.z + 1);
    vec3 a = p_a.xyz, b = p_b.xyz, c = p_c.xyz;
    vec3 n_a = side * q_a.xyz, n_b = side * q_b.xyz, n_c = side * q_c.xyz;
    vec3 weights = barycentric(position, a, b, c);
    vec3 x = weights.x * a + weights.y * b + weights.z * c;
    vec3 across = side * cross(b - a, c - a);
    float area_2 = length(across);
    vec3 step_off = area_2 > 0.0 ? OFFSET * inversesqrt(area_2) * across : vec3(0.0);
    // What hides light may be coarser than what is drawn: its facets lie below the curved surface by more than these do.
    vec3 lift = side > 0.0 ? vec3(p_a.w, p_b.w, p_c.w) : vec3(q_a.w, q_b.w, q_c.w);
    step_off += dot(weights, lift) * normalize(weights.x * n_a + weights.y * n_b + weights.z * n_c);
    frame_p = vec4(lifted(x, weights, a, b, c, n_a, n_b, n_c) + step_off, float(number));
    frame_b = weights.yz;
#ifdef CUT_OUT
    vec2 uv = weights.x * texelFetch(cut_uv, corners.x).xy + weights.y * texelFetch(cut_uv, corners.y).xy
        + weights.z * texelFetch(cut_uv, corners.z).xy;
#endif
#ifdef OPENINGS
    if (texture(opacity_map, vec3(uv * opacity_repeats, 0.0)).r < opacity_threshold) discard;
#endif
#ifdef FABRIC_MASK
    // By whole texels, so that the cloths of a mask leave no gap and do not overlap.
    ivec2 mask_size = textureSize(mask_map, 0);
    ivec2 texel = min(ivec2(fract(uv * mask_repeats) * vec2(mask_size)), mask_size - 1);
    if (int(texelFetch(mask_map, texel, 0).r) != mask_number) discard;
#endif
#ifdef BEHIND
    if (gl_FragCoord.z <= texelFetch(behind, ivec2(gl_FragCoord.xy), 0).r + BEHIND_STEP) discard;
#endif
#ifdef AMONG_OTHERS
    if (hidden_by_others && gl_FragCoord.z > texelFetch(nearer, ivec2(gl_FragCoord.xy), 0).r) discard;
    if (number >= one_sided_from && !gl_FrontFacing) discard;
#endif
}
