// Suns are discs: every pixel sends a ray to one point of them (define FIRST), and others where pixels side by side, which have
// other points, do not agree: there is a penumbra.   [own, docs/shadows.md]
#include "trace/sun_disc.glsl"
uniform samplerBuffer sun_data;  // toward each sun's middle; tangent of its radius
#ifdef FIRST
uniform int sun_count;           // at least 1
#else
uniform int sun_number;          // one a dispatch: loops may end silently after 65,535 iterations
#endif
uniform float first_turn;        // of this sample of the pixel

const ivec2 SUN_POINTS = ivec2(8, 16);  // of a narrow disc, and of one
const float WIDE = 0.0175;       // of a degree and more
const int PATTERN = 16;          // pixels, four by four, whose first rays go to points of their own
const float AGREE = 0.02;        // how far two pixels may differ

// Of a turn, well mixed over the pixels: interleaved gradient noise.   [Jimenez 2014, "Next generation post processing"]
float turn_at(ivec2 pixel) {
    return fract(52.9829189 * fract(dot(vec2(pixel), vec2(0.06711056, 0.00583715))) + first_turn);
}

vec3 first_point(ivec2 pixel, vec4 sun) {
    int n = (pixel.x & 1) * 8 + (pixel.y & 1) * 4 + (pixel.x & 2) + (pixel.y >> 1 & 1);
    return disc_direction(sun.xyz, sun.w, disc_point(n, PATTERN, first_turn));
}

int points_of(vec4 sun) { return sun.w < WIDE ? SUN_POINTS.x : SUN_POINTS.y; }

vec3 point_of(ivec2 pixel, vec4 sun, int n) {
    return disc_direction(sun.xyz, sun.w, disc_point(n, points_of(sun), turn_at(pixel)));
}
