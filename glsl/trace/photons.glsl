// Photons: where they begin, and what their density says of the light.   Twin: glcloth/twins/photons.py
#include "core/math.glsl"

const float CLOSE = 0.02;    // m off a surface that still counts as on it, as of a rug on a floor; glcloth/curtain/rims.py has it too
const float BENT = 0.1;      // the same, for a surface that bends, by the distance
const float NEVER = 3e38;

// [Hammersley 1960; Cranley and Patterson 1976]  Point i of `count` evenly spread ones of the unit square, all shifted round it.
vec2 shifted_hammersley(uint i, uint count, vec2 shift) {
    return fract(vec2((float(i) + 0.5) / float(count), float(bitfieldReverse(i) >> 8) / 16777216.0) + shift);
}

// [own]  The squared distance of two points of a surface with the normal n; NEVER where they do not lie on the same one.
float disc_distance(vec3 way, vec3 n) {
    float d2 = dot(way, way);
    float off = abs(dot(way, n));
    return off <= CLOSE || off * off <= BENT * BENT * d2 ? d2 : NEVER;
}

// [Silverman 1986, section 4.2, Epanechnikov's kernel]  What a photon at a squared distance counts for in a disc of squared
// radius r2; the disc has the area pi r2 / 2 by it.
float disc_kernel(float d2, float r2) {
    return max(1.0 - d2 / r2, 0.0);
}

// [own]  The share of that area about p which an edge from a to b cuts off; the surface, with the normal n, lies on its left.
// All edges of a surface together leave of the area what lies on it: the kernel is summed along rays from p up to the edges,
// F(u) = 1 - (1 - u)^2 of it up to u = d2 / r2, and the angle that an edge takes up, h dx / (h^2 + x^2), is gone through in
// closed form.
float cut_share(vec3 p, vec3 a, vec3 b, vec3 n, float r) {
    vec3 along = normalize(b - a);
    float h = dot(cross(n, along), p - a) / r;
    float reach = sqrt(max(1.0 - h * h, 0.0));
    vec2 x = clamp(vec2(dot(a - p, along), dot(b - p, along)) / r, -reach, reach);
    vec2 angle = (h < 0.0 ? -1.0 : 1.0) * atan(x, vec2(max(abs(h), 1e-7)));
    vec2 sum = angle + x * h * (h * h - 2.0 + x * x / 3.0);
    return (sum.y - sum.x) / (2.0 * PI);
}
