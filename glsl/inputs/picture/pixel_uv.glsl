// Where on its threads a pixel lies.   [own]
#include "inputs/picture/uv_footprint.glsl"
#include "inputs/picture/gbuffer.glsl"
#include "inputs/picture/gbuffer_point.glsl"

uniform samplerBuffer thread_points;    // of the mesh, three texels a vertex: the first is the position
uniform isamplerBuffer thread_corners;  // three a triangle
uniform samplerBuffer thread_uv;        // of each vertex, metres
uniform vec4 viewpoint;        // (eye, 1), or of parallel rays (direction toward the camera, 0)

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
    return uv_footprint(b, c, uv, uv_b, uv_c, w, d, t);
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
