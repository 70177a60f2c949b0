// Where on its threads a pixel lies: UVs in metres, and how they change from pixel to pixel.   [own]
#include "core/footprint.glsl"
#include "inputs/picture/gbuffer.glsl"
#include "inputs/picture/gbuffer_point.glsl"

uniform samplerBuffer thread_points;    // of the mesh, three texels a vertex: the first is the position
uniform isamplerBuffer thread_corners;  // three a triangle
uniform samplerBuffer thread_uv;        // of each vertex, metres
uniform vec4 viewpoint;        // (eye, 1), or of parallel rays (direction toward the camera, 0)
uniform mat3 step_from_pixel;  // how a ray changes to the next pixel: its direction, or of parallel rays its origin

struct PixelUv {
    vec2 uv;
    vec2 x, y;  // change to the next pixel of the row, of the column
    vec3 omega;  // toward the viewer: along u and v, and off the cloth
};

PixelUv pixel_uv(ivec2 pixel) {
    int number = triangle_at(pixel);
    int i = texelFetch(thread_corners, 3 * number).x, j = texelFetch(thread_corners, 3 * number + 1).x;
    int k = texelFetch(thread_corners, 3 * number + 2).x;
    vec3 a = texelFetch(thread_points, 3 * i).xyz;
    vec3 b = texelFetch(thread_points, 3 * j).xyz - a, c = texelFetch(thread_points, 3 * k).xyz - a;
    vec2 uv = texelFetch(thread_uv, i).xy;
    vec2 uv_b = texelFetch(thread_uv, j).xy - uv, uv_c = texelFetch(thread_uv, k).xy - uv;
    vec3 w = weights_at(pixel);
    vec3 d = ray_from_pixel * vec3(vec2(pixel) + 0.5, 1.0);
    float t = viewpoint.w > 0.0 ? length(a + w.y * b + w.z * c - viewpoint.xyz) / length(d) : 1.0;
    vec3 n = cross(b, c);
    n *= inversesqrt(max(dot(n, n), 1e-30));
    vec3 x = place_step(d, step_from_pixel[0], n, t), y = place_step(d, step_from_pixel[1], n, t);
    vec3 away = d * -inversesqrt(dot(d, d));
    vec3 omega = vec3(uv_step(away, b, c, uv_b, uv_c), abs(dot(away, n)));
    return PixelUv(uv + w.y * uv_b + w.z * uv_c, uv_step(x, b, c, uv_b, uv_c), uv_step(y, b, c, uv_b, uv_c), omega);
}

// The mean over a pixel of a layer of pictures that repeat over UVs. `most_taps`, places that are read at most, must be a
// uniform: a limit that the compiler sees is unrolled.
vec3 mean_of_pixel(sampler2DArray pictures, float layer, PixelUv at, vec2 repeats, float most_taps) {
    vec2 size = vec2(textureSize(pictures, 0).xy), x = at.x * repeats, y = at.y * repeats;
    vec2 taps = taps_and_level(x * size, y * size, most_taps);
    vec2 way = dot(x * size, x * size) > dot(y * size, y * size) ? x : y;
    vec3 sum = vec3(0.0);
    float tap = 0.0;
    do {
        vec2 place = at.uv * repeats + way * ((tap + 0.5) / taps.x - 0.5);
        sum += textureLod(pictures, vec3(place, layer), taps.y).rgb;
    } while (++tap < taps.x);
    return sum / taps.x;
}
