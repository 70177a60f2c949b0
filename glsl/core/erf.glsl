// The error function and its inverse, which GLSL lacks. Twin: glcloth/twins/erf.py

// [own]  erf(x) = 2 / sqrt(pi) times the integral of exp(-t^2) from 0 to x, as x P(x^2) / Q(x^2): a minimax fit on
// |x| <= 3.9, where 1 - erf is 4e-8. Absolute and relative error 4e-7 in single precision.
float erf(float x) {
    float z = min(x * x, 15.21);
    float P = 1.12837903 + z * (0.191941561 + z * (0.0529669936 + z * (0.00383690074 + z * (2.87457956e-4 + z * 2.05038471e-6))));
    float Q = 1.0 + z * (0.503435558 + z * (0.114758432 + z * (0.0151092530 + z * (1.18174071e-3 + z * 3.82307525e-5))));
    return clamp(clamp(x, -3.9, 3.9) * P / Q, -1.0, 1.0);
}

// [Giles 2010, "Approximating the erfinv function"]  x with erf(x) = y, -1 < y < 1; single precision.
float erf_inverse(float y) {
    float w = -log((1.0 - y) * (1.0 + y));
    float near = w - 2.5;
    float p = 0.246640727 + near * (-0.00417768164 + near * (-0.00125372503 + near * (0.00021858087 + near
        * (-4.39150654e-06 + near * (-3.5233877e-06 + near * (3.43273939e-07 + near * 2.81022636e-08))))));
    float far = sqrt(max(w, 5.0)) - 3.0;
    float q = 1.00167406 + far * (0.00943887047 + far * (-0.0076224613 + far * (0.00573950773 + far * (-0.00367342844 + far
        * (0.00134934322 + far * (0.000100950558 - far * 0.000200214257))))));
    return y * (w < 5.0 ? 1.50140941 + near * p : 2.83297682 + far * q);
}
