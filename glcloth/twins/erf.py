"""Twin of glsl/core/erf.glsl: the error function and its inverse, in float64."""

import math

import numpy as np


def erf(x):
    """2 / sqrt(pi) times the integral of exp(-t^2) from 0 to x."""
    return np.vectorize(math.erf, otypes=[float])(x)


def erf_inverse(y):
    """x with erf(x) = y, -1 < y < 1, by Newton's method from within.   [own]"""
    y = np.asarray(y, float)
    # From below: erf bends down there, so that no step goes too far.
    x, wanted = np.zeros_like(y), np.abs(y)
    for _ in range(60):
        x = x + (wanted - erf(x)) * np.sqrt(np.pi) / 2 * np.exp(np.minimum(x * x, 600.0))
    return np.sign(y) * x
