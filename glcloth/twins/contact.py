"""Twin of glsl/simulate/contact.glsl, in float64 and, for the hash, in wrapping 32-bit integers."""

import numpy as np

from .collide import friction


def bucket(cell, size):
    x, y, z = np.moveaxis(cell.astype(np.int64), -1, 0)
    mixed = (x * 73856093) ^ (y * 19349663) ^ (z * 83492791)
    return (mixed % 2**32 % size).astype(np.int32)


def part(p_0, p_1, w_0, w_1, gap, slide, mu):
    distance = np.linalg.norm(p_0 - p_1, axis=-1)
    apart = distance > 0
    n = (p_0 - p_1) / np.where(apart, distance, 1)[..., None]
    push = gap - distance
    tangential = slide - np.sum(slide * n, axis=-1)[..., None] * n
    moved = push[..., None] * n + friction(tangential, np.maximum(push, 0), mu)
    share = w_0 / np.where(w_0 + w_1 > 0, w_0 + w_1, 1)
    return np.where(((push > 0) & apart)[..., None], share[..., None] * moved, 0.0)
