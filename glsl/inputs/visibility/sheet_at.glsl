// One sheet of cloth where a ray meets it, and how much of its light goes straight on. Needs struct Visit with the triangle and
// the weights of a hit.   [own]
#include "core/shading_frame.glsl"
#include "woven/sheet.glsl"
// Defines: FINER, where rays may meet the triangles of passes/visibility/finer.comp.
#ifdef FINER
#include "inputs/visibility/coarse.glsl"
#endif
uniform samplerBuffer sheet_data;   // two texels a cloth: rho, k_a, k_t, diffuse; tau, the triangle behind its last
uniform int sheet_count;            // triangles behind the last cloth's hide light
uniform isamplerBuffer hit_corners;  // three a triangle, in the order that hits are weighted in
uniform samplerBuffer hit_vertices;  // three texels a vertex: position, normal, tangent

const int MOST_LAYERS = 8;       // of cloth, that light goes through
const float LEAST_LEFT = 1e-3;   // less light than that is none

struct Sheet {
    int number;   // of the cloth; -1: none that lets light through
    vec3 omega;   // the ray's direction back, surface frame
};

// Of a cloth where its triangle is met.
Sheet sheet_of(int c, Visit visit, vec3 d) {
    int t = int(visit.triangle);
    if (c == sheet_count || texelFetch(sheet_data, 2 * c).yz == vec2(0.0)) return Sheet(-1, vec3(0.0));
    ivec3 corners = 3 * ivec3(texelFetch(hit_corners, 3 * t).x, texelFetch(hit_corners, 3 * t + 1).x,
        texelFetch(hit_corners, 3 * t + 2).x);
    vec3 w = vec3(1.0 - visit.weights.x - visit.weights.y, visit.weights);
    vec3 N = w.x * texelFetch(hit_vertices, corners.x + 1).xyz + w.y * texelFetch(hit_vertices, corners.y + 1).xyz
        + w.z * texelFetch(hit_vertices, corners.z + 1).xyz;
    vec3 x = w.x * texelFetch(hit_vertices, corners.x + 2).xyz + w.y * texelFetch(hit_vertices, corners.y + 2).xyz
        + w.z * texelFetch(hit_vertices, corners.z + 2).xyz;
    if (dot(N, d) > 0.0) N = -N;
    N = facing_normal(normalize(N), -d, 0.02);
    x = orthogonal_part(x, N);
    return Sheet(c, -vec3(dot(d, x), dot(d, cross(N, x)), dot(d, N)));
}

Sheet sheet_at(Visit visit, vec3 d) {
#ifdef FINER
    visit = coarse(visit);
#endif
    int t = int(visit.triangle), c = 0;
    while (c < sheet_count && float(t) >= texelFetch(sheet_data, 2 * c + 1).w) ++c;
    return sheet_of(c, visit, d);
}

// The share of the light along a ray that a sheet lets straight on: for rays the one place that says it.
vec3 T_s_of(Sheet sheet) {
    if (sheet.number < 0) return vec3(0.0);
    vec4 p = texelFetch(sheet_data, 2 * sheet.number);
    return T_straight(sheet.omega, p.y, p.z, texelFetch(sheet_data, 2 * sheet.number + 1).xyz, p.x, p.w);
}

// And the share that it sends evenly toward where the ray comes from: radiance by irradiance / PI.
vec3 T_lambert_of(Sheet sheet) {
    if (sheet.number < 0) return vec3(0.0);
    vec4 p = texelFetch(sheet_data, 2 * sheet.number);
    return T_lambert(sheet.omega, p.z, texelFetch(sheet_data, 2 * sheet.number + 1).xyz, p.x, p.w);
}

bool worth(vec3 T) { return max(T.r, max(T.g, T.b)) > LEAST_LEFT; }
