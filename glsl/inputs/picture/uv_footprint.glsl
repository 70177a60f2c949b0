// Where on its threads a ray meets a triangle, and how much of them its pixel covers.   [own]
#include "core/footprint.glsl"

uniform mat3 step_from_pixel;  // how a ray changes to the next pixel: its direction, or of parallel rays its origin

struct PixelUv {
    vec2 uv;  // metres
    vec2 x, y;  // change to the next pixel of the row, of the column
    vec3 omega;  // toward the viewer: along u and v, and off the cloth
};

// `b`, `c`: from the triangle's first corner to the others; uv, and uv_b and uv_c, likewise; w: of the place; d: of the ray; t: its
// length to the place in lengths of d; 1 of parallel rays.
PixelUv uv_footprint(vec3 b, vec3 c, vec2 uv, vec2 uv_b, vec2 uv_c, vec3 w, vec3 d, float t) {
    vec3 n = cross(b, c);
    n *= inversesqrt(max(dot(n, n), 1e-30));
    vec3 x = place_step(d, step_from_pixel[0], n, t), y = place_step(d, step_from_pixel[1], n, t);
    vec3 away = d * -inversesqrt(dot(d, d));
    vec3 omega = vec3(uv_step(away, b, c, uv_b, uv_c), abs(dot(away, n)));
    return PixelUv(uv + w.y * uv_b + w.z * uv_c, uv_step(x, b, c, uv_b, uv_c), uv_step(y, b, c, uv_b, uv_c), omega);
}
