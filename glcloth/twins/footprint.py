"""What a pixel covers of a pattern on a surface. Twin of glsl/core/footprint.glsl."""

from __future__ import annotations

import numpy as np


def _dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return (a * b).sum(-1, keepdims=True)


def place_step(d, change, n, t):
    """How far the place where the ray of direction d meets a plane of normal n moves when d changes.   [own]"""
    d, change, n = (np.asarray(x, float) for x in (d, change, n))
    facing, least = _dot(n, d), 0.01 * np.sqrt(_dot(d, d))
    facing = np.where(facing < 0.0, np.minimum(facing, -least), np.maximum(facing, least))
    return np.asarray(t, float)[..., None] * (change - d * (_dot(n, change) / facing))


def uv_step(way, to_b, to_c, uv_b, uv_c):
    """How much the coordinates of a triangle change along a step in its plane.   [own]"""
    way, to_b, to_c, uv_b, uv_c = (np.asarray(x, float) for x in (way, to_b, to_c, uv_b, uv_c))
    n = np.cross(to_b, to_c)
    n2 = np.maximum(_dot(n, n), 1e-30)
    return uv_b * (_dot(np.cross(way, to_c), n) / n2) + uv_c * (_dot(np.cross(to_b, way), n) / n2)


def taps_and_level(x, y, most):
    """(taps, level) of a map where a pixel has sides x and y, in texels.   [own]"""
    a, b = (np.linalg.norm(np.asarray(v, float), axis=-1) for v in (x, y))
    longer, shorter = np.maximum(a, b), np.maximum(np.minimum(a, b), 1.0)
    taps = np.clip(np.ceil(longer / shorter - 0.5), 1.0, most)
    return np.stack([taps, 0.5 * np.log2(shorter * np.maximum(longer / taps, shorter))], -1)


def lean(omega):
    """How far the sides of warp and weft turn to light from omega.   [own, facts-weave 3]"""
    omega = np.asarray(omega, float)
    return np.clip(omega[..., [1, 0]] / (np.maximum(omega[..., 2:], 0.0) + 0.35), -1.0, 1.0)


def relief_way(omega):
    """How far to the side a place of height 1 stands before the cloth seen from omega.   [own, facts-weave 4]"""
    omega = np.asarray(omega, float)
    return omega[..., :2] / np.maximum(omega[..., 2:], 0.3)


def with_mean(value, mean, wanted):
    """Values whose mean is `mean`, changed so that it is `wanted`.   [own]"""
    value, mean = np.asarray(value, float), np.asarray(mean, float)
    wanted = np.asarray(wanted, float)[..., None]
    least = 0.1 * wanted
    return (value + np.maximum(least - mean, 0.0)) * (wanted / np.maximum(mean, least))
