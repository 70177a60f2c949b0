"""Gauss quadrature of any weight, many weights at once."""

from __future__ import annotations

import numpy as np


def recurrence(x: np.ndarray, w: np.ndarray, n: int) -> tuple[np.ndarray, np.ndarray]:
    """Coefficients (a, b) [..., n] of the monic orthogonal polynomials of discrete measures (Stieltjes' procedure).

    p_{i+1} = (x - a_i) p_i - b_i p_{i-1}; b_0 is the mass.   [Gautschi 2004, "Orthogonal Polynomials", section 2.2]

    Parameters
    ----------
    x, w : [..., m] points and weights >= 0, the sum of the weights > 0
    """
    a, b = np.zeros((*w.shape[:-1], n)), np.zeros((*w.shape[:-1], n))
    before, p, norm = np.zeros_like(w), np.ones_like(w), 1.0
    for i in range(n):
        wp2 = w * p * p
        own = np.maximum(wp2.sum(-1), 1e-300)
        a[..., i] = (wp2 * x).sum(-1) / own
        b[..., i] = own / norm
        before, p = p, (x - a[..., i, None]) * p - (b[..., i, None] * before if i else 0.0)
        norm = own
    return a, b


def polynomial(x: np.ndarray, a: np.ndarray, b: np.ndarray, degree: int) -> np.ndarray:
    """The monic orthogonal polynomial of a recurrence [..., n] at points x [..., m]."""
    before, p = np.zeros_like(x), np.ones_like(x)
    for i in range(degree):
        before, p = p, (x - a[..., i, None]) * p - (b[..., i, None] * before if i else 0.0)
    return p


def nodes_and_weights(a: np.ndarray, b: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Nodes and weights [..., n] of the Gauss rule of a recurrence [..., n].   [Golub & Welsch 1969]"""
    n = a.shape[-1]
    if n == 1:
        return a.copy(), b.copy()
    # Two and three nodes in closed form: these are the commonest rules, and eigh is slow for many tiny matrices.
    if n == 3:
        return _three_nodes(a, b)
    if n == 2:
        middle, half = 0.5 * (a[..., 0] + a[..., 1]), 0.5 * (a[..., 0] - a[..., 1])
        root = np.sqrt(half**2 + b[..., 1])
        share = 0.5 - 0.5 * half / np.maximum(root, 1e-300)
        nodes = np.stack([middle - root, middle + root], -1)
        return nodes, np.stack([share, 1.0 - share], -1) * b[..., :1]
    matrix = np.zeros((*a.shape, n))
    i = np.arange(n)
    matrix[..., i, i] = a
    matrix[..., i[1:], i[:-1]] = np.sqrt(np.maximum(b[..., 1:], 0.0))
    values, vectors = np.linalg.eigh(matrix)
    return values, vectors[..., 0, :] ** 2 * b[..., :1]


def _three_nodes(a: np.ndarray, b: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The same for n = 3: roots of the characteristic cubic by cosines, weights by Christoffel's formula."""
    mean = a.mean(-1, keepdims=True)
    d = a - mean
    p = np.sqrt(((d * d).sum(-1) + 2.0 * (b[..., 1] + b[..., 2])) / 6.0) + 1e-300
    determinant = d.prod(-1) - d[..., 0] * b[..., 2] - d[..., 2] * b[..., 1]
    angle = np.arccos(np.clip(determinant / (2.0 * p**3), -1.0, 1.0)) / 3.0
    turn = 2.0 * np.pi / 3.0 * np.array([1.0, 2.0, 0.0])  # ascending: cos(angle + 2 pi / 3) is the least
    nodes = mean + 2.0 * p[..., None] * np.cos(angle[..., None] + turn)
    norm = np.cumprod(b, -1)
    p_1 = nodes - a[..., :1]
    p_2 = p_1 * (nodes - a[..., 1:2]) - b[..., 1:2]
    weights = 1.0 / (1.0 / norm[..., :1] + p_1**2 / norm[..., 1:2] + p_2**2 / norm[..., 2:])
    return nodes, weights
