"""Twin of glsl/trace/smooth.glsl: a triangle of a smooth surface cut into four, in float64."""

import numpy as np


def curved_middle(a, b, n_a, n_b):
    """The middle [..., 3] of an edge, on the cubic that leaves both ends along the surface there.   [own]"""
    a, b, n_a, n_b = (np.asarray(v, float) for v in (a, b, n_a, n_b))
    d = b - a
    bend = (n_b * d).sum(-1, keepdims=True) * n_b - (n_a * d).sum(-1, keepdims=True) * n_a
    return 0.5 * (a + b) + 0.125 * bend


def middle_normal(n_a, n_b):
    """Its normal [..., 3]: the mean of those at the ends.   [own]"""
    n_a = np.asarray(n_a, float)
    n = n_a + np.asarray(n_b, float)
    square = (n * n).sum(-1, keepdims=True)
    return np.where(square > 1e-12, n / np.sqrt(np.where(square > 1e-12, square, 1.0)), n_a)


def weights_of_whole(weights, part):
    """Barycentric coordinates [..., 3] in the triangle of a point of one of its four parts.   [own]"""
    weights, part = np.asarray(weights, float), np.asarray(part)[..., None]
    u, v, w = np.moveaxis(weights, -1, 0)
    middle = 0.5 * np.stack([u + w, u + v, v + w], -1)
    return np.where(part == 3, middle, 0.5 * weights + 0.5 * (part == np.arange(3)))


def part_at(weights):
    """The part [...] that a point lies in.   [own]"""
    u, v, w = np.moveaxis(np.asarray(weights, float), -1, 0)
    return np.where(u > 0.5, 0, np.where(v > 0.5, 1, np.where(w > 0.5, 2, 3)))


def weights_in_part(weights, part):
    """Barycentric coordinates [..., 3] in one of the four parts by those in the triangle.   [own]"""
    weights, part = np.asarray(weights, float), np.asarray(part)[..., None]
    return np.where(part == 3, 1.0 - 2.0 * weights[..., [2, 0, 1]], 2.0 * weights - (part == np.arange(3)))
