"""Twin of glsl/trace/ground.glsl."""

import numpy as np


def ground_place(p, scale, rings, sectors):
    """(ring, sector) [..., 2] of points p [..., 2] = (x, z) from the ground's middle, both with fractions.   [own]"""
    p = np.asarray(p, float)
    r = np.hypot(p[..., 0], p[..., 1])
    ring = np.minimum(r / (r + scale) * (np.asarray(rings) + 1.0), rings)
    turn = np.arctan2(p[..., 0], p[..., 1]) / (2.0 * np.pi)
    return np.stack([ring, sectors * np.where(turn < 0.0, turn + 1.0, turn)], -1)
