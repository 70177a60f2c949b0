"""Twin of glsl/core/math.glsl, in float64."""

import numpy as np


def pow5(x):
    """x to the fifth power."""
    return np.asarray(x) ** 5
