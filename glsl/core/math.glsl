// Common numbers.
const float PI = 3.14159265358979323846;

// [Roberts 2018, "The unreasonable effectiveness of quasirandom sequences", R2]  Step of a lattice that runs in step with
// nothing: fract(n * R2) is evenly spread for any number of points.
const vec2 R2 = vec2(0.7548776662, 0.5698402910);

// [own] x^5 by three multiplications; pow(x, 5.0) costs five times as much and is undefined at x < 0.
float pow5(float x) {
    float x2 = x * x;
    return x2 * x2 * x;
}

// [own]  The largest component.
float largest(vec3 v) { return max(v.r, max(v.g, v.b)); }
