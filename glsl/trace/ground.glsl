// Where on the ground's rings of vertices a point lies; glcloth/geometry/props.py lays them.   Twin: glcloth/twins/ground.py
#include "core/math.glsl"

const uint GROUND = 0x7fffffffu;  // its number as a triangle

// [own]  (ring, sector) of a point p = (x, z) from the ground's middle, both with fractions: ring 0 is the middle.
vec2 ground_place(vec2 p, float scale, float rings, float sectors) {
    float r = length(p);
    float ring = min(r / (r + scale) * (rings + 1.0), rings);
    float turn = r > 0.0 ? atan(p.x, p.y) / (2.0 * PI) : 0.0;
    return vec2(ring, sectors * (turn < 0.0 ? turn + 1.0 : turn));
}
