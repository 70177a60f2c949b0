"""Twin of glsl/direct/pool.glsl: nodes on the narrow lobe of one tangent, in float64."""

import numpy as np


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
