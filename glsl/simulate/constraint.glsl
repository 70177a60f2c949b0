// The constraints of the cloth, after XPBD: Macklin, Mueller, Chentanez 2016, "XPBD: position-based simulation of
// compliant constrained dynamics", eq. 18 with one iteration per substep, so that the multiplier starts from zero:
//     lambda = -C / (sum_i w_i |grad_i C|^2 + alpha / h^2),   dx_i = w_i grad_i C lambda.
// w is the inverse mass in 1/kg (0 = pinned), alpha_h2 = alpha / h^2 in 1/kg.  Twin: glcloth/twins/constraint.py

// [own] Distance |p_1 - p_0| = rest with compliance alpha (m/N): returns n lambda, n = (p_1 - p_0) / |p_1 - p_0|.
// dx_0 = -w_0 n lambda, dx_1 = w_1 n lambda.  Zero when the points coincide (no direction).
vec3 lambda_stretch(vec3 p_0, vec3 p_1, float w_0, float w_1, float rest, float alpha_h2) {
    vec3 e = p_1 - p_0;
    float l = length(e);
    float bottom = l * (w_0 + w_1 + alpha_h2);
    return bottom > 0.0 ? e * ((rest - l) / bottom) : vec3(0.0);
}

// [own] Bending of three points in a row, C = p_0 - 2 p_1 + p_2 as a vector constraint: the quadratic energy of
// isometric bending (Bergou, Wardetzky, Harmon, Zorin, Grinspun 2006, "A quadratic bending model for inextensible
// surfaces") along one yarn. Returns the vector lambda; dx_0 = w_0 lambda, dx_1 = -2 w_1 lambda, dx_2 = w_2 lambda.
vec3 lambda_bend(vec3 p_0, vec3 p_1, vec3 p_2, float w_0, float w_1, float w_2, float alpha_h2) {
    vec3 C = (p_0 - p_1) + (p_2 - p_1);
    float bottom = w_0 + 4.0 * w_1 + w_2 + alpha_h2;
    return bottom > 0.0 ? C * (-1.0 / bottom) : vec3(0.0);
}

// The edges of one line of the cloth, solved together: with n_k the direction and C_k = l_k - rest of edge k from vertex
// k to k + 1, the system A lambda = -C is tridiagonal,
//     A_kk = w_k + w_(k+1) + alpha_h2,   A_(k,k-1) = -w_k n_(k-1) . n_k,
// and Thomas' algorithm solves it exactly. One edge at a time, as lambda_stretch does, would leave every edge of a
// hanging cloth a spring of stiffness m / (2 h^2): some ten per cent too long at 10 substeps.

// [own] Forward step: (pivot, d) of edge k from those of edge k - 1; `off` = A_(k,k-1), `diagonal` = A_kk.
//     pivot_k = A_kk - A_(k,k-1)^2 / pivot_(k-1),   d_k = (-C_k - A_(k,k-1) d_(k-1)) / pivot_k.
// An edge between two pinned vertices has nothing to move: pivot 1, d 0.
vec2 eliminate(float diagonal, float off, float C, vec2 before) {
    float pivot = diagonal - off * off / before.x;
    return diagonal > 0.0 ? vec2(pivot, (-C - off * before.y) / pivot) : vec2(1.0, 0.0);
}

// [own] Backward step: lambda_k from (pivot_k, d_k), `off` = A_(k+1,k) and lambda_(k+1).
//     lambda_k = d_k - A_(k,k+1) lambda_(k+1) / pivot_k
float substitute(vec2 eliminated, float off, float lambda_next) {
    return eliminated.y - off * lambda_next / eliminated.x;
}
