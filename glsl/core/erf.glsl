// The error function, which GLSL lacks. Twin: glcloth/twins/erf.py

// [own]  erf(x) = 2 / sqrt(pi) times the integral of exp(-t^2) from 0 to x, as x P(x^2) / Q(x^2): a minimax fit on
// |x| <= 3.9, where 1 - erf is 4e-8. Absolute and relative error 4e-7 in single precision.
float erf(float x) {
    float z = min(x * x, 15.21);
    float P = 1.12837903 + z * (0.191941561 + z * (0.0529669936 + z * (0.00383690074 + z * (2.87457956e-4 + z * 2.05038471e-6))));
    float Q = 1.0 + z * (0.503435558 + z * (0.114758432 + z * (0.0151092530 + z * (1.18174071e-3 + z * 3.82307525e-5))));
    return clamp(clamp(x, -3.9, 3.9) * P / Q, -1.0, 1.0);
}
