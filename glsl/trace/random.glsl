// Numbers that look random, and directions drawn with them.   Twin: glcloth/twins/random.py
#include "core/math.glsl"
#include "core/shading_frame.glsl"

// [Jarzynski 2020, with Olano, "Hash functions for GPU rendering", pcg3d]  Three hashes of three integers.
uvec3 hash3(uvec3 v) {
    v = v * 1664525u + 1013904223u;
    v.x += v.y * v.z;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    v ^= v >> 16u;
    v.x += v.y * v.z;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    return v;
}

// [own]  A point of the unit square [0, 1)^2 from two hashes; 24 bits each, so that 1 cannot arise by rounding.
vec2 unit_square(uvec2 hash) {
    return vec2(hash >> 8u) / 16777216.0;
}

// [own]  A direction about +z, distributed as its cosine.
vec3 cosine_direction(vec2 u) {
    float r = sqrt(u.x);
    float phi = 2.0 * PI * u.y;
    return vec3(r * cos(phi), r * sin(phi), sqrt(1.0 - u.x));
}

// [Walter 2007, Eq. 35-36]  A facet of GGX, distributed as D cos: theta = atan(r sqrt(u / (1 - u))).
vec3 facet_direction(vec2 u, float roughness) {
    float phi = 2.0 * PI * u.y;
    float t2 = roughness * roughness * u.x / (1.0 - u.x);
    float c = inversesqrt(1.0 + t2);
    float s = c * sqrt(t2);
    return vec3(s * cos(phi), s * sin(phi), c);
}
