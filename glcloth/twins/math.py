"""Twin of glsl/core/math.glsl, in float64."""

import numpy as np


def pow5(x):
    """x to the fifth power."""
    return np.asarray(x) ** 5


def largest(v):
    """The largest component of v [..., 3].   [own]"""
    return np.asarray(v, float).max(-1)
