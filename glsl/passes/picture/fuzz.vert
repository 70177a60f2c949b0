#version 430
// Hairs that stand out from cloth: each a strip that faces the camera.   [own]
// An instance is one hair; its vertices go along it, left and right in turn.
#include "core/disk.glsl"
#include "core/shading_frame.glsl"
#include "fibre/hair.glsl"
#include "inputs/picture/hair_color.glsl"
uniform samplerBuffer hair_data;      // of each hair: (triangle, weights of two corners, length); eight random numbers; (width, side)
uniform samplerBuffer thread_points;  // of the mesh, three texels a vertex: position, normal, tangent
uniform isamplerBuffer thread_corners;
uniform samplerBuffer thread_uv;
uniform mat4 clip_from_world;
uniform mat3 view_from_world;
uniform vec2 half_size;               // of the picture, pixels
uniform float metres_in_pixel;        // at a distance of 1, or, of parallel rays, everywhere
uniform float diameter;
uniform int segments;
uniform float warp_share;             // of the hairs
uniform sampler2DArray hair_table;    // passes/picture/hair_light.comp
uniform samplerBuffer hair_lights;    // of each light: (axis, how wide); its colour
uniform int light_count;
uniform float gaussian_count;
uniform usamplerBuffer mean_data;     // visibility of the vertices, as passes/visibility/pixels.comp reads it
uniform int group_count;              // 0: nothing is hidden
out vec3 place;
out vec3 radiance;
out float across;                     // pixels from the middle of the hair
out float wide;                       // pixels
flat out float lighter;               // than the mean of all hairs, -1 to 1

// How far a hair sees a light.
float seen(ivec3 corners, vec3 weights, int side, int number) {
    if (group_count == 0) return 1.0;
    ivec3 texel = (2 * corners + side) * group_count + (number >> 2);
    vec3 V = vec3(unpackUnorm4x8(texelFetch(mean_data, texel.x).x)[number & 3],
        unpackUnorm4x8(texelFetch(mean_data, texel.y).x)[number & 3],
        unpackUnorm4x8(texelFetch(mean_data, texel.z).x)[number & 3]);
    return dot(weights, V);
}

void main() {
    int hair = 4 * gl_InstanceID;
    vec4 root = texelFetch(hair_data, hair), own = texelFetch(hair_data, hair + 3);
    int side = int(own.y);
    vec4 way = texelFetch(hair_data, hair + 1 + side), bend = texelFetch(hair_data, hair + 2 - side);
    float width = own.x;
    ivec3 corners = ivec3(texelFetch(thread_corners, 3 * int(root.x)).x, texelFetch(thread_corners, 3 * int(root.x) + 1).x,
        texelFetch(thread_corners, 3 * int(root.x) + 2).x);
    vec3 weights = vec3(1.0 - root.y - root.z, root.yz);
    mat3 p = mat3(texelFetch(thread_points, 3 * corners.x).xyz, texelFetch(thread_points, 3 * corners.y).xyz,
        texelFetch(thread_points, 3 * corners.z).xyz);
    vec3 N = normalize(mat3(texelFetch(thread_points, 3 * corners.x + 1).xyz, texelFetch(thread_points, 3 * corners.y + 1).xyz,
        texelFetch(thread_points, 3 * corners.z + 1).xyz) * weights);
    vec4 along = weights.x * texelFetch(thread_points, 3 * corners.x + 2) + weights.y * texelFetch(thread_points, 3 * corners.y + 2)
        + weights.z * texelFetch(thread_points, 3 * corners.z + 2);
    vec3 x = orthogonal_part(along.xyz, N), y = cross(N, x);
    N *= side == 0 ? 1.0 : -1.0;
    mat3 frame = mat3(x, y, N);

    float s = float(gl_VertexID >> 1) / float(segments), step = 0.05;
    vec3 middle = p * weights + frame * hair_place(way, bend, s) * root.w;
    vec3 direction = normalize(frame * (hair_place(way, bend, s + step) - hair_place(way, bend, max(s - step, 0.0))));
    place = middle;
    lighter = 2.0 * fract(32.0 * bend.w) - 1.0;

    vec4 here = clip_from_world * vec4(middle, 1.0), next = clip_from_world * vec4(middle + 0.01 * root.w * direction, 1.0);
    vec2 on_screen = half_size * (next.xy / next.w - here.xy / here.w);
    vec2 aside = vec2(-on_screen.y, on_screen.x) * inversesqrt(max(dot(on_screen, on_screen), 1e-20));
    float pixel = metres_in_pixel * here.w;
    wide = width * diameter / pixel * (1.0 - 0.6 * s * s);
    across = (0.5 * wide + 0.5) * ((gl_VertexID & 1) == 0 ? -1.0 : 1.0);
    gl_Position = here;
    gl_Position.xy += across * aside / half_size * here.w;

    int yarn = fract(64.0 * way.w) < warp_share ? 0 : 1;
    vec2 uv = weights.x * texelFetch(thread_uv, corners.x).xy + weights.y * texelFetch(thread_uv, corners.y).xy
        + weights.z * texelFetch(thread_uv, corners.z).xy;
    vec3 A = hair_color(uv, yarn), t = view_from_world * direction;
    t = t.z < 0.0 ? -t : t;
    vec2 texel = 0.5 + (0.5 - 0.5 / float(textureSize(hair_table, 0).x)) * to_disk(t);
    radiance = vec3(0.0);
    int light = 0;
    do {
        vec4 axis = texelFetch(hair_lights, 2 * light);
        vec4 terms = textureLod(hair_table, vec3(texel, float(light)), 0.0);
        vec2 both = yarn == 0 ? terms.xy : terms.zw;
        float V = float(light) < gaussian_count ? seen(corners, weights, side, 1 + light) : 1.0;
        radiance += V * hair_horizon(N, axis.xyz, axis.w) * texelFetch(hair_lights, 2 * light + 1).rgb * (both.x + A * both.y);
    } while (++light < light_count);
}
