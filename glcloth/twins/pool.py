"""Twin of glsl/direct/pool.glsl: nodes on the narrow lobe of one tangent, in float64."""

import numpy as np

from .fresnel import F_schlick
from .scatter import wrap
from .slots import sigma_of_series
from .weight import D_mask


def _place(mu, low, high, width):
    return mu / np.pi + 0.5 * (np.arctan((mu - low) / width) + np.arctan((mu - high) / width))


def column_of_lobe(mu, low, high, width):
    """The place in 0..1 of a lobe about theta_i = mu in a table that is dense about low and high.   [own]"""
    first, last = _place(-0.5 * np.pi, low, high, width), _place(0.5 * np.pi, low, high, width)
    return (_place(mu, low, high, width) - first) / (last - first)


def lobe_at_column(column, low, high, width):
    """The inverse of `column_of_lobe`, by bisection.   [own]"""
    column = np.asarray(column, float)
    a, b = np.full(column.shape, -0.5 * np.pi), np.full(column.shape, 0.5 * np.pi)
    for _ in range(30):
        middle = 0.5 * (a + b)
        below = column_of_lobe(middle, low, high, width) < column
        a, b = np.where(below, middle, a), np.where(below, b, middle)
    return 0.5 * (a + b)


def sin_limit(sin_theta, cos_theta, cos_tilt, sin_tilt):
    """sin(phi_max) of a tilted tangent at inclination theta.   [own]"""
    q = np.clip(sin_tilt * sin_theta / np.maximum(cos_tilt * cos_theta, 1e-6), 0, 1)
    return np.sqrt(1 - q * q)


def scatter_pair(cos_phi, sin_phi, phi_o, cos_theta_d, F_0, series):
    """M, F_r and cos(phi_d / 2) [..., 6], each at phi and at -phi, by angles.   [Miz 5-6, 12]"""
    phi, at_o = np.arctan2(sin_phi, cos_phi)[..., None] * [1, -1], np.arctan2(phi_o[..., 1:], phi_o[..., :1])
    phi_d = wrap(phi - at_o)
    g = np.exp(-((phi_d / sigma_of_series(series)) ** 2))
    M = D_mask(g, cos_phi[..., None], np.maximum(phi_o[..., :1], 0))
    F_r = F_schlick(F_0[..., None], cos_theta_d[..., None] * np.cos(phi_d / 2))
    return np.concatenate([M, F_r, np.cos(phi_d / 2)], -1)
