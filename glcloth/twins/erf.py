"""Twin of glsl/core/erf.glsl: the error function, in float64."""

import math

import numpy as np


def erf(x):
    """2 / sqrt(pi) times the integral of exp(-t^2) from 0 to x."""
    return np.vectorize(math.erf, otypes=[float])(x)
