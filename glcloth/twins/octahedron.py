"""Twin of glsl/trace/octahedron.glsl: unit vectors as points of a square, in float64."""

import numpy as np


def octahedral(n):
    """The point [..., 2] in [-1, 1]^2 of vectors n [..., 3]: the octahedron unfolded.   [Cigolle 2014]"""
    n = np.asarray(n, float)
    p = n[..., :2] / np.abs(n).sum(-1, keepdims=True)
    folded = (1 - np.abs(p[..., ::-1])) * np.where(p >= 0, 1.0, -1.0)
    return np.where(n[..., 2:] < 0, folded, p)


def from_octahedral(p):
    """The unit vectors [..., 3] of points p [..., 2] in [-1, 1]^2.   [Cigolle 2014]"""
    p = np.asarray(p, float)
    z = 1 - np.abs(p).sum(-1)
    xy = np.where(z[..., None] < 0, (1 - np.abs(p[..., ::-1])) * np.where(p >= 0, 1.0, -1.0), p)
    n = np.concatenate([xy, z[..., None]], -1)
    return n / np.linalg.norm(n, axis=-1, keepdims=True)
