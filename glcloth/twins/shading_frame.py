"""Twin of glsl/core/shading_frame.glsl, in float64."""

import numpy as np


def _unit(v):
    return v / np.linalg.norm(v, axis=-1, keepdims=True)


def facing_normal(N, omega_o, least):
    """The smooth normal, bent until the cosine to omega_o is `least`.   [own]"""
    N, omega_o = np.asarray(N, float), np.asarray(omega_o, float)
    cos_no = np.sum(N * omega_o, -1, keepdims=True)
    across = N - cos_no * omega_o
    length = np.linalg.norm(across, axis=-1, keepdims=True)
    least = np.asarray(least, float)[..., None]
    bent = across / np.maximum(length, 1e-12) * np.sqrt(1 - least**2) + least * omega_o
    return np.where(cos_no >= least, N, np.where(length < 1e-6, omega_o, bent))


def mirrored_direction(d, N, N_g):
    """d [..., 3] mirrored at N, or at N_g where that would go into the surface.   [own]"""
    d, N, N_g = (np.asarray(v, float) for v in (d, N, N_g))
    smooth, geometric = (d - 2 * np.sum(d * n, -1, keepdims=True) * n for n in (N, N_g))
    return np.where(np.sum(smooth * N_g, -1, keepdims=True) > 0, smooth, geometric)


def orthogonal_part(v, N):
    """The unit part of v perpendicular to N; any perpendicular where v is along N.   [own]"""
    v, N = np.asarray(v, float), np.asarray(N, float)
    x = v - np.sum(v * N, -1, keepdims=True) * N
    axis = np.where(np.abs(N[..., :1]) < 0.7, [1.0, 0, 0], [0, 1.0, 0])
    other = axis - np.sum(axis * N, -1, keepdims=True) * N
    return _unit(np.where(np.sum(x * x, -1, keepdims=True) <= 1e-8 * np.sum(v * v, -1, keepdims=True), other, x))
