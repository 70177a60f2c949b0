"""Twin of glsl/sg/fresnel_sum.glsl: Fresnel terms as polynomials (Mizutani et al. 2012, Eq. 13), in float64."""

import numpy as np


def C_l(F_0, cos_theta_d):
    """Coefficients [..., 6] of F_r in the powers 0-5 of cos(phi_d / 2).   [Miz 13]"""
    F_0, x = np.broadcast_arrays(np.asarray(F_0, float), -np.asarray(cos_theta_d, float))
    binomial = np.array([1, 5, 10, 10, 5, 1])
    C = (1 - F_0)[..., None] * binomial * x[..., None] ** np.arange(6)
    return C + F_0[..., None] * (np.arange(6) == 0)


def D_l(F_0, cos_theta_d):
    """Coefficients [..., 11] of (1 - F_r)^2 in the powers 0-10 of cos(phi_d / 2): C_l of 1 - F_r, squared."""
    transmitted = (np.arange(6) == 0) - C_l(F_0, cos_theta_d)
    D = np.zeros((*transmitted.shape[:-1], 11))
    for l in range(6):
        D[..., l : l + 6] += transmitted[..., l, None] * transmitted
    return D


def surface_sum(F_0, cos_theta_d, T_1, T_5):
    """sum_l C_l T_(l + 1).   [Miz 15]"""
    T = np.concatenate([T_1, T_5], -1)
    return np.sum(C_l(F_0, cos_theta_d) * T[..., :6], -1)


def volume_sum(F_0, cos_theta_d, T_1, T_5, T_9):
    """sum_l D_l T_l, l = 1..10 (D_0 is 0)."""
    T = np.concatenate([T_1, T_5, T_9], -1)
    return np.sum(D_l(F_0, cos_theta_d)[..., 1:] * T[..., :10], -1)
