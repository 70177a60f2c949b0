"""Twin of glsl/direct/view.glsl: directions omega_o as points of a disk that is finer toward its rim, in float64."""

import numpy as np


def to_view(omega, rim):
    """The point [..., 2] of a direction [..., 3] above the horizon, which is the unit circle.   [own]"""
    omega = np.asarray(omega, float)
    return omega[..., :2] / (1 + np.asarray(rim)[..., None] * omega[..., 2:])


def from_view(p, rim):
    """The direction [..., 3] of a point [..., 2]; points beyond the unit circle are those of the horizon.   [own]

    |p| (1 + rim z) = sqrt(1 - z^2), solved for z.
    """
    p, rim = np.asarray(p, float), np.asarray(rim, float)[..., None]
    p = p / np.maximum(np.linalg.norm(p, axis=-1, keepdims=True), 1)
    square = (p * p).sum(-1, keepdims=True)
    z = (np.sqrt(1 + square * (rim**2 - 1)) - rim * square) / (1 + rim**2 * square)
    return np.concatenate([p * (1 + rim * z), z], -1)
