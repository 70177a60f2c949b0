"""Twin of glsl/fibre/tangent.glsl: the terms of one tangent (Mizutani et al. 2012, Eq. 5-6), in float64."""

import numpy as np

from .scatter import f_s
from .weight import M, P


def tangent_terms(omega_i, omega_o, weight, eta, k_d, gamma_s, gamma_v, sigma):
    """(P, R f_rs cos(theta_i), R f_rv cos(theta_i) / A) [..., 3] with R = weight M P.   [Miz 5-6, erratum E8]"""
    P_t = P(omega_i, omega_o, sigma)
    R = weight * M(omega_i, omega_o, sigma) * P_t
    with np.errstate(divide="ignore", invalid="ignore"):
        f = f_s(omega_i, omega_o, eta, k_d, gamma_s, gamma_v)
    scale = R * np.hypot(omega_i[..., 1], omega_i[..., 2])
    terms = np.where((R > 0)[..., None], scale[..., None] * f, 0.0)
    return np.concatenate([P_t[..., None], terms], -1)
