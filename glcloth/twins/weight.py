"""Twin of glsl/fibre/weight.glsl: shadowing-masking and projected length (Mizutani et al. 2012, Eq. 6), in float64."""

import numpy as np

from .scatter import wrap


def D_mask(x, y, z):
    """(1 - x) y z + x min(y, z).   [Miz, below 6]"""
    return (1 - x) * y * z + x * np.minimum(y, z)


def masked(projected_i, projected_o, sigma):
    """D_mask of two projected directions [..., 2] = (sine, cosine) times their length.   [Miz, below 6]"""
    a_i = np.arctan2(projected_i[..., 0], projected_i[..., 1])
    a_o = np.arctan2(projected_o[..., 0], projected_o[..., 1])
    g = np.exp(-((wrap(a_i - a_o) / sigma) ** 2))
    value = D_mask(g, np.maximum(np.cos(a_i), 0), np.maximum(np.cos(a_o), 0))
    vanish = np.minimum(np.linalg.norm(projected_i, axis=-1), np.linalg.norm(projected_o, axis=-1)) < 1e-9
    return np.where(vanish, 0.0, value)


def M(omega_i, omega_o, sigma):
    """Shadowing-masking, by the azimuths phi about the thread.   [Miz, below 6]"""
    return masked(np.asarray(omega_i)[..., 1:], np.asarray(omega_o)[..., 1:], sigma)


def P(omega_i, omega_o, sigma):
    """Projected length, by the angles psi in the plane of t and n.   [Miz, below 6]"""
    return masked(np.asarray(omega_i)[..., 0::2], np.asarray(omega_o)[..., 0::2], sigma)
