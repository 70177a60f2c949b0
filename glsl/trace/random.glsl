// Numbers that look random or fill the unit interval evenly, and directions drawn with them.   Twin: glcloth/twins/random.py
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

// [Burley 2020; constants of Vegdahl 2021]  The point of [0, 2^32) of a van der Corput sequence, scrambled as Owen does: every
// interval of a sequence of 2^k points that begins at a multiple of 2^k, cut in 2^k, holds one of them in each.
uint owen_scrambled(uint index, uint seed) {
    index ^= index * 0x3d20adeau;
    index += seed;
    index *= (seed >> 16u) | 1u;
    index ^= index * 0x05526c56u;
    index ^= index * 0x53a22864u;
    return bitfieldReverse(index);
}

// [Sobol 1967]  The index whose van der Corput point is that of this index in the second dimension: by Pascal's triangle mod 2.
uint second_index(uint index) {
    index ^= (index >> 1u) & 0x55555555u;
    index ^= (index >> 2u) & 0x33333333u;
    index ^= (index >> 4u) & 0x0f0f0f0fu;
    index ^= (index >> 8u) & 0x00ff00ffu;
    return index ^ (index >> 16u);
}

// [Burley 2020, section 5]  Sample `index` of the sequence `key` in [0, 1)^3: x and y fill the square, and z the interval; what
// is drawn with other keys is independent of it. 24 bits each, so that 1 cannot arise by rounding.
vec3 stratified(uint index, uvec3 key) {
    uvec3 other = hash3(key);
    uint i = owen_scrambled(bitfieldReverse(index), key.x), j = owen_scrambled(bitfieldReverse(index), other.x);
    uvec3 at = uvec3(owen_scrambled(i, key.y), owen_scrambled(second_index(i), key.z), owen_scrambled(j, other.y));
    return vec3(at >> 8u) / 16777216.0;
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
