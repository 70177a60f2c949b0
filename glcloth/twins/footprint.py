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


def level_number(level, steps, choice):
    """(number of a version of a map, share of the next) that are read at a mip level.   [own]"""
    level, steps, choice = (np.asarray(x, float) for x in (level, steps, choice))
    whole, end, count = np.moveaxis(steps, -1, 0)
    number = np.minimum(level, whole) + 4.0 * np.clip(level - whole, 0.0, end - whole) + np.maximum(level - end, 0.0)
    one = level <= end
    first = np.minimum(np.floor(np.where(one, number + choice, number)), count - 1.0)
    return np.stack([first, np.where(one | (first == count - 1.0), 0.0, number - first)], -1)


def level_of_number(number, steps):
    """The mip level of a version.   [own]"""
    number = np.asarray(number, float)
    whole, end, _ = np.moveaxis(np.asarray(steps, float), -1, 0)
    last = whole + 4.0 * (end - whole)
    return (
        np.minimum(number, whole) + 0.25 * np.clip(number - whole, 0.0, last - whole) + np.maximum(number - last, 0.0)
    )


def place_in(rect, place):
    """The place in the picture of all versions.   [own]"""
    rect, place = np.asarray(rect, float), np.asarray(place, float)
    return rect[..., :2] + (place - np.floor(place)) * rect[..., 2:]
