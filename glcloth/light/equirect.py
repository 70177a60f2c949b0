"""The equirectangular picture of the sphere: directions, solid angles, averaging and look-up.

The y axis is up and u runs as in Mitsuba's `envmap`: the middle column looks along +z, the left edge along -z, and
u = 1/4 along +x. v = 0 is the zenith.

       u = 0      1/4      1/2      3/4       1
  v = 0 +----------- zenith +y -------------+
        |  -z      +x       +z      -x      -z
  v = 1 +----------- nadir  -y -------------+
"""

from __future__ import annotations

from functools import lru_cache
from itertools import pairwise

import numpy as np


def direction_from_uv(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Unit directions [..., 3] of map coordinates u, v in [0, 1]; the inverse of uv_from_direction."""
    phi, theta = 2 * np.pi * np.asarray(u, float), np.pi * np.asarray(v, float)
    sin_theta = np.sin(theta)
    return np.stack(np.broadcast_arrays(np.sin(phi) * sin_theta, np.cos(theta), -np.cos(phi) * sin_theta), -1)


def uv_from_direction(omega: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Map coordinates (u in [0, 1), v in [0, 1]) of unit directions omega [..., 3]."""
    omega = np.asarray(omega, float)
    x, y, z = omega[..., 0], omega[..., 1], omega[..., 2]
    u = np.arctan2(x, -z) / (2 * np.pi)
    # hypot keeps the digits near the poles that acos(y) loses. Tiny negative u rounds up to 1, which is u = 0.
    return np.where(u < 0, u + 1.0, u) % 1.0, np.arctan2(np.hypot(x, z), y) / np.pi


@lru_cache(maxsize=4)
def row_solid_angles(height: int, width: int) -> np.ndarray:
    """Exact solid angle [H] of one texel of each row; width * sum = 4 pi."""
    edges = np.cos(np.linspace(0.0, np.pi, height + 1))
    omega = (edges[:-1] - edges[1:]) * (2 * np.pi / width)
    omega.setflags(write=False)
    return omega


def texel_directions(height: int, width: int, rows: slice = slice(None)) -> np.ndarray:
    """Unit directions [H, W, 3] of the texel centres (of the given rows)."""
    v = (np.arange(height)[rows] + 0.5) / height
    return direction_from_uv(((np.arange(width) + 0.5) / width)[None, :], v[:, None])


def total(radiance: np.ndarray) -> np.ndarray:
    """Integral of a map [H, W, C] over the sphere: radiance times solid angle, float64 [C]."""
    height, width = radiance.shape[:2]
    return row_solid_angles(height, width) @ radiance.sum(axis=1, dtype=np.float64)


def lookup(radiance: np.ndarray, omega: np.ndarray) -> np.ndarray:
    """Bilinear radiance [..., C] of a map [H, W, C] toward directions omega [..., 3].

    u wraps around; across a pole the neighbour is the texel on the other side of it.
    """
    height, width = radiance.shape[:2]
    u, v = uv_from_direction(omega)
    x, y = u * width - 0.5, v * height - 0.5
    x_0, y_0 = np.floor(x).astype(int), np.floor(y).astype(int)
    f_x, f_y = (x - x_0)[..., None], (y - y_0)[..., None]

    def texel(column, row):
        over_pole = (row < 0) | (row >= height)
        column = np.where(over_pole, column + width // 2, column) % width
        return radiance[np.where(row < 0, -1 - row, np.where(row >= height, 2 * height - 1 - row, row)), column]

    top = (1 - f_x) * texel(x_0, y_0) + f_x * texel(x_0 + 1, y_0)
    bottom = (1 - f_x) * texel(x_0, y_0 + 1) + f_x * texel(x_0 + 1, y_0 + 1)
    return (1 - f_y) * top + f_y * bottom


def _overlaps(edges_in: np.ndarray, edges_out: np.ndarray) -> list[tuple[int, np.ndarray]]:
    """For each output interval: its first input interval, and its overlap with that and the next ones."""
    result = []
    for low, high in pairwise(edges_out):
        first = max(int(np.searchsorted(edges_in, low, "right")) - 1, 0)
        last = max(int(np.searchsorted(edges_in, high, "left")), first + 1)
        cut = np.clip(edges_in[first : last + 1], low, high)
        result.append((first, np.diff(cut)))
    return result


def downsample(radiance: np.ndarray, height: int, width: int) -> np.ndarray:
    """Average a map [H, W, C] over the texels of a coarser one, by solid angle; float64 [height, width, C].

    Exact for any sizes: the integral over the sphere is kept. A map that is already as small is returned as float64.
    """
    H, W, C = radiance.shape
    if (H, W) == (height, width):
        return radiance.astype(np.float64)
    # In cos(theta) the solid angle is uniform, so overlaps of row intervals are exact weights.
    rows = _overlaps(-np.cos(np.linspace(0, np.pi, H + 1)), -np.cos(np.linspace(0, np.pi, height + 1)))
    tall = np.empty((height, W, C))
    for out, (first, weight) in enumerate(rows):
        block = radiance[first : first + len(weight)].reshape(len(weight), W * C)
        tall[out] = (weight / weight.sum() @ block.astype(np.float64)).reshape(W, C)
    if W == width:
        return tall
    if W % width == 0:
        return tall.reshape(height, width, W // width, C).mean(axis=2)
    columns = _overlaps(np.linspace(0, 1, W + 1), np.linspace(0, 1, width + 1))
    result = np.empty((height, width, C))
    for out, (first, weight) in enumerate(columns):
        result[:, out] = np.einsum("hwc,w->hc", tall[:, first : first + len(weight)], weight / weight.sum())
    return result


def resize(radiance: np.ndarray, height: int, width: int) -> np.ndarray:
    """A map of another size: averaged when smaller, bilinear when larger; float64 [height, width, C]."""
    if radiance.shape[0] >= height and radiance.shape[1] >= width:
        return downsample(radiance, height, width)
    return lookup(np.asarray(radiance, float), texel_directions(height, width))
