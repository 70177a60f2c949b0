"""Twin of glsl/simulate/constraint.glsl (Macklin et al. 2016, eq. 18; Bergou et al. 2006), in float64."""

import numpy as np


def lambda_stretch(p_0, p_1, w_0, w_1, rest, alpha_h2):
    C = np.linalg.norm(p_1 - p_0, axis=-1) - rest
    n = (p_1 - p_0) / np.linalg.norm(p_1 - p_0, axis=-1)[..., None]
    # |grad C| = 1 at both points.
    return n * (-C / (w_0 + w_1 + alpha_h2))[..., None]


def lambda_bend(p_0, p_1, p_2, w_0, w_1, w_2, alpha_h2):
    C = p_0 - 2 * p_1 + p_2
    # grad C = (1, -2, 1).
    return -C / (w_0 + 4 * w_1 + w_2 + alpha_h2)[..., None]


def eliminate(diagonal, off, C, before):
    pivot = diagonal - off**2 / before[..., 0]
    result = np.stack([pivot, (-C - off * before[..., 1]) / pivot], axis=-1)
    return np.where((diagonal > 0)[..., None], result, np.array([1.0, 0.0]))


def substitute(eliminated, off, lambda_next):
    return eliminated[..., 1] - off * lambda_next / eliminated[..., 0]


def solve_line(p, w, rest, alpha_h2):
    """Return the line of vertices p [n, 3] after one exact step of all its edges, by the full matrix."""
    e = np.diff(p, axis=0)
    length = np.linalg.norm(e, axis=1)
    n = e / length[:, None]
    count = len(n)
    gradient = np.zeros((count, count + 1, 3))
    gradient[np.arange(count), np.arange(count)] = -n
    gradient[np.arange(count), np.arange(count) + 1] = n
    A = np.einsum("kvc,v,lvc->kl", gradient, w, gradient) + alpha_h2 * np.eye(count)
    free = np.diag(A) > 0
    lambda_ = np.zeros(count)
    lambda_[free] = np.linalg.solve(A[np.ix_(free, free)], -(length - rest)[free])
    return p + w[:, None] * np.einsum("kvc,k->vc", gradient, lambda_)
