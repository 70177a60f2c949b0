"""Twin of glsl/core/disk.glsl: directions of a hemisphere as points of a disk, in float64."""

import numpy as np


def to_disk(omega):
    """The point [..., 2] of a direction [..., 3] above the horizon, which is the unit circle.   [own]"""
    omega = np.asarray(omega, float)
    return omega[..., :2] / (1 + omega[..., 2:])


def from_disk(p):
    """The direction [..., 3] of a point [..., 2]; points beyond the unit circle are those of the horizon.   [own]"""
    p = np.asarray(p, float)
    p = p / np.maximum(np.linalg.norm(p, axis=-1, keepdims=True), 1)
    square = (p * p).sum(-1, keepdims=True)
    return np.concatenate([2 * p, 1 - square], -1) / (1 + square)
