"""Twin of glsl/fibre/frame.glsl: the frame of one tangent of a yarn, in float64."""

import numpy as np


def tangent_axes(yarn, cos_tilt, sin_tilt):
    """The axes (t, b, n) of a tangent in the surface frame, each [..., 3]."""
    yarn, c, s = np.broadcast_arrays(yarn, np.asarray(cos_tilt, float), np.asarray(sin_tilt, float))
    zero, one, first = np.zeros_like(c), np.ones_like(c), (yarn == 0)[..., None]
    t = np.where(first, np.stack([c, zero, -s], -1), np.stack([zero, c, -s], -1))
    b = np.where(first, np.stack([zero, one, zero], -1), np.stack([-one, zero, zero], -1))
    n = np.where(first, np.stack([s, zero, c], -1), np.stack([zero, s, c], -1))
    return t, b, n


def tangent_from_surface(omega, yarn, cos_tilt, sin_tilt):
    """(omega . t, omega . b, omega . n) [..., 3] of directions omega [..., 3] in the surface frame."""
    return np.stack([np.sum(omega * axis, -1) for axis in tangent_axes(yarn, cos_tilt, sin_tilt)], -1)
