"""Twin of glsl/core/origin.glsl, in float64."""

import numpy as np


def _dot(a, b):
    return np.sum(a * b, -1, keepdims=True)


def barycentric(x, a, b, c):
    """Barycentric coordinates [..., 3] of a point in the plane of a triangle, kept within it.   [own]"""
    x, a, b, c = (np.asarray(p, float) for p in (x, a, b, c))
    n = np.cross(b - a, c - a)
    n2 = _dot(n, n)
    safe = np.where(n2 > 0, n2, 1.0)
    v = np.clip(_dot(np.cross(x - a, c - a), n) / safe, 0.0, 1.0)
    w = np.clip(_dot(np.cross(b - a, x - a), n) / safe, 0.0, 1.0 - v)
    return np.where(n2 > 0, np.concatenate([1.0 - v - w, v, w], -1), [1.0, 0.0, 0.0])


def lifted(x, weights, a, b, c, n_a, n_b, n_c):
    """The point of a triangle lifted to the curved surface that its corners' normals tell of.   [Hanika 2021, "Hacking
    the shadow terminator"]"""
    x, weights = np.asarray(x, float), np.asarray(weights, float)
    out = x.copy()
    for i, (corner, n) in enumerate(((a, n_a), (b, n_b), (c, n_c))):
        corner, n = np.asarray(corner, float), np.asarray(n, float)
        out = out - weights[..., i : i + 1] * np.minimum(_dot(x - corner, n), 0.0) * n
    return out
