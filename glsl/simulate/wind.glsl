// Air on cloth: the drag of a triangle, and a gusty wind.  Twin: glcloth/twins/wind.py

const float RHO_AIR = 1.225;  // kg/m^3, sea level, 15 degrees Celsius

// [own] Force in newtons on a triangle of vector area S (m^2, either side) in air that passes it at v_rel (m/s):
//     F = 1/2 rho |v_rel| (C_n (v_rel . n) n + C_t (v_rel - (v_rel . n) n)) A,   A = |S|, n = S / A,
// the drag equation split along and across the sheet. C_n, C_t are the drag coefficients.
vec3 drag(vec3 v_rel, vec3 S, float C_n, float C_t) {
    float A = length(S);
    if (A <= 0.0) {
        return vec3(0.0);
    }
    vec3 n = S / A;
    vec3 normal_part = dot(v_rel, n) * n;
    return 0.5 * RHO_AIR * A * length(v_rel) * (C_n * normal_part + C_t * (v_rel - normal_part));
}

// [own] Drag may slow the air's passage but not turn it round within one substep h: F is shortened so that
// |F| h / m <= |v_rel|, m the triangle's mass. Without this the explicit step overshoots on light cloth.
vec3 drag_limited(vec3 F, vec3 v_rel, float m, float h) {
    float most = m * length(v_rel) / h;
    float l = length(F);
    return l > most ? F * (most / l) : F;
}

// [own] Strength of the wind at p (m) and time t (s) relative to its mean, for a field that drifts with `drift` (m/s):
// three sines whose periods have no common multiple, so that it does not repeat; gustiness g keeps it in [1 - g, 1 + g].
float gust(vec3 p, float t, vec3 drift, float g) {
    vec3 q = p - drift * t;
    return 1.0 + g * (0.5 * sin(1.7 * t + 1.1 * p.x - 0.7 * p.y)
                    + 0.3 * sin(dot(q, vec3(2.3, 1.3, 3.1)) + 0.9)
                    + 0.2 * sin(dot(q, vec3(-4.1, 5.3, 1.9)) + 2.7 * t));
}
