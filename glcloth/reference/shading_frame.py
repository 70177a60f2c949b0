"""Twin of glsl/core/shading_frame.glsl, in float64."""

import numpy as np


def _unit(v):
    return v / np.linalg.norm(v, axis=-1, keepdims=True)


def facing_normal(N, omega_o):
    """The smooth normal, bent until the cosine to omega_o is about 0.02.   [own]"""
    N, omega_o = np.asarray(N, float), np.asarray(omega_o, float)
    cos_no = np.sum(N * omega_o, -1, keepdims=True)
    return np.where(cos_no >= 0.02, N, _unit(N + (0.02 - cos_no) * omega_o))


def orthogonal_part(v, N):
    """The unit part of v perpendicular to N; any perpendicular where v is along N.   [own]"""
    v, N = np.asarray(v, float), np.asarray(N, float)
    x = v - np.sum(v * N, -1, keepdims=True) * N
    axis = np.where(np.abs(N[..., :1]) < 0.7, [1.0, 0, 0], [0, 1.0, 0])
    other = axis - np.sum(axis * N, -1, keepdims=True) * N
    return _unit(np.where(np.sum(x * x, -1, keepdims=True) <= 1e-8 * np.sum(v * v, -1, keepdims=True), other, x))
