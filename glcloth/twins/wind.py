"""Twin of glsl/simulate/wind.glsl, in float64."""

import numpy as np

RHO_AIR = 1.225


def drag(v_rel, S, C_n, C_t):
    A = np.linalg.norm(S, axis=-1)[..., None]
    n = S / np.where(A > 0, A, 1)
    v_n = np.sum(v_rel * n, axis=-1)[..., None] * n
    v_t = v_rel - v_n
    speed = np.linalg.norm(v_rel, axis=-1)[..., None]
    return 0.5 * RHO_AIR * C_n[..., None] * A * speed * v_n + 0.5 * RHO_AIR * C_t[..., None] * A * speed * v_t


def drag_limited(F, v_rel, m, h):
    size = np.linalg.norm(F, axis=-1)
    most = m * np.linalg.norm(v_rel, axis=-1) / h
    return F * np.where(size > most, most / np.where(size > 0, size, 1), 1)[..., None]


def gust(p, t, drift, g):
    x, y, _ = np.moveaxis(p, -1, 0)
    q = p - drift * t[..., None]
    waves = (
        0.5 * np.sin(1.7 * t + 1.1 * x - 0.7 * y)
        + 0.3 * np.sin(q @ np.array([2.3, 1.3, 3.1]) + 0.9)
        + 0.2 * np.sin(q @ np.array([-4.1, 5.3, 1.9]) + 2.7 * t)
    )
    return 1 + g * waves
