"""Twin of glsl/fibre/scatter.glsl: scattering by one thread (Mizutani et al. 2012, Eq. 5), in float64, by angles."""

import numpy as np

from .fresnel import F_0, F_schlick


def angles(omega):
    """theta and phi [...] of directions [..., 3] given as (omega . t, omega . b, omega . n).   [Miz section 1.2]"""
    omega = np.asarray(omega, float)
    return np.arctan2(omega[..., 0], np.hypot(omega[..., 1], omega[..., 2])), np.arctan2(omega[..., 1], omega[..., 2])


def wrap(x):
    """An angle brought into [-pi, pi]."""
    return np.arctan2(np.sin(x), np.cos(x))


def g_u(x, gamma):
    """Gaussian with unit integral.   [Miz 4]"""
    return np.exp(-((x / gamma) ** 2)) / (np.sqrt(np.pi) * gamma)


def f_s(omega_i, omega_o, eta, k_d, gamma_s, gamma_v):
    """(f_rs, f_rv / A) / cos^2(theta_d), [..., 2].   [Miz 5, erratum E8]"""
    theta_i, phi_i = angles(omega_i)
    theta_o, phi_o = angles(omega_o)
    theta_d, theta_h = (theta_i - theta_o) / 2, (theta_i + theta_o) / 2
    half_phi_d = wrap(phi_i - phi_o) / 2
    F_r = F_schlick(F_0(eta), np.cos(theta_d) * np.cos(half_phi_d))
    surface = F_r * np.cos(half_phi_d) * g_u(theta_h, gamma_s)
    volume = (1 - F_r) ** 2 * ((1 - k_d) * g_u(theta_h, gamma_v) + k_d) / (np.cos(theta_i) + np.cos(theta_o))
    return np.stack([surface, volume], -1) / (np.cos(theta_d) ** 2)[..., None]
