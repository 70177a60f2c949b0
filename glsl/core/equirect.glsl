// The equirectangular picture of the sphere, +Y up, as Mitsuba's `envmap`.   Twin: glcloth/twins/equirect.py
#include "core/math.glsl"

// [own]  (u, v) in [0, 1] of a unit direction: u = 1/4 along +x, 1/2 along +z; v = 0 at the zenith.
vec2 uv_from_direction(vec3 omega) {
    float u = atan(omega.x, -omega.z) / (2.0 * PI);
    return vec2(u < 0.0 ? u + 1.0 : u, atan(length(omega.xz), omega.y) / PI);
}
