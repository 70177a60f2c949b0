"""Twin of glsl/sg/coordinates.glsl: the axes of the paper method's tables, and the inverses that place the nodes."""

import numpy as np


def node_coordinate(x, n):
    """Texture coordinate of x in [0, 1] in a table of n texels with its first node at 0 and its last at 1."""
    return (0.5 + np.clip(x, 0, 1) * (np.asarray(n) - 1)) / n


def unit_from_half_circle(angle):
    """[-pi/2, pi/2] to [0, 1]."""
    return np.asarray(angle) / np.pi + 0.5


def half_circle_from_unit(x):
    """Inverse of unit_from_half_circle."""
    return (np.asarray(x) - 0.5) * np.pi


def unit_from_circle(phi, inner):
    """|phi| in [0, pi] to [0, 1] such that the share `inner` lies below pi/2."""
    x = np.abs(phi) / (np.pi / 2)
    return np.where(x < 1, x * inner, inner + (x - 1) * (1 - np.asarray(inner)))


def circle_from_unit(x, inner):
    """|phi| of unit_from_circle."""
    x, inner = np.asarray(x), np.asarray(inner)
    return np.pi / 2 * np.where(x < inner, x / inner, 1 + (x - inner) / (1 - inner))


def unit_from_kappa(kappa_prime, last):
    """kappa_prime >= 0 to [0, 1] at `last`, logarithmic."""
    return np.log1p(kappa_prime) / np.log1p(last)


def kappa_from_unit(x, last):
    """Inverse of unit_from_kappa."""
    return np.expm1(np.asarray(x) * np.log1p(last))


def level_from_sharpness(sharpness, first, last, levels):
    """Sharpness to levels: 0 at 0, 1 at `first`, levels - 1 at `last` and beyond."""
    sharpness, first = np.asarray(sharpness, float), np.asarray(first, float)
    ratio = np.log(np.asarray(last) / first) / (np.asarray(levels) - 2)
    high = 1 + np.log(np.maximum(sharpness, first) / first) / ratio
    return np.where(sharpness < first, sharpness / first, np.minimum(high, np.asarray(levels) - 1))


def sharpness_from_level(level, first, last, levels):
    """Inverse of level_from_sharpness."""
    level = np.asarray(level, float)
    ratio = np.log(last / first) / (levels - 2)
    return np.where(level < 1, level * first, first * np.exp((level - 1) * ratio))
