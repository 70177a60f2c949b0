// Common numbers.
const float PI = 3.14159265358979323846;

// [own] x^5 by three multiplications; pow(x, 5.0) costs five times as much and is undefined at x < 0.
float pow5(float x) {
    float x2 = x * x;
    return x2 * x2 * x;
}
