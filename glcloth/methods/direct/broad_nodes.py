"""Directions at which broad light is looked up, and what each stands for in between.   [own]

Light that is a sum of Gaussians no sharper than kappa is known, to a fraction of a percent, from its radiance E at some
tens of directions x_j: E(omega) = sum_j B_j(omega) E(x_j). B is the best linear interpolation (kriging) of random light,
the Gaussians' axes anywhere, whose covariance is the integral over all axes of the product of two Gaussians:

    C(a, b) = sinh(kappa |a + b|) / |a + b|, but for a constant.

What cloth makes of it, sum_j E(x_j) int f cos(theta_i) B_j, needs the integrals for a fabric and omega_o only.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from ...twins.directions import even_directions
from ...twins.disk import from_disk
from .gaussian_nodes import sky_nodes

# The sharpest Gaussian that so many directions serve. A multiple of 16: passes/methods/view_table.comp makes as many at a time.
LEVELS = ((2.2, 16), (5.8, 32), (9.0, 48))
NUGGET = 1e-6  # of the variance, that keeps the weights from growing where directions are more than enough
BASIS_SIZE = 48  # of the maps of B
FIXED_LEVEL = 8  # of the rule for what varies slowly with omega_i


def directions(level: int) -> np.ndarray:
    """Directions [J, 3] above the horizon, surface frame, even in solid angle."""
    return even_directions(LEVELS[level][1])


def basis(level: int, omega: np.ndarray) -> np.ndarray:
    """B [N, J] at unit directions omega [N, 3]."""
    x = directions(level)
    return np.linalg.solve(_covariance(level, x, x) + NUGGET * np.eye(len(x)), _covariance(level, x, omega)).T


def _covariance(level: int, a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """C [len(a), len(b)] of a mixture of light: constant, and of three sharpnesses, each of variance 1."""
    s = np.linalg.norm(a[:, None] + b[None], axis=-1)
    kappa = LEVELS[level][0]
    return 0.25 + 0.25 * sum((_sinhc(k, s) for k in (1.0, kappa / 3.0, kappa)), np.zeros(()))


def _sinhc(k: float, s: np.ndarray) -> np.ndarray:
    """sinh(k s) / (k s), divided by its value at s = 2."""
    x = np.maximum(k * s, 1e-9)
    return -np.expm1(-2 * x) / x * np.exp(x - 2 * k) * 2 * k / -np.expm1(-4 * k)


@lru_cache
def fixed_rule(level: int) -> tuple[np.ndarray, np.ndarray]:
    """Directions [n, 3] of a rule over the hemisphere, and its weights times B [n, J]."""
    omega, weight = np.split(sky_nodes(FIXED_LEVEL), [3], axis=-1)
    return omega, weight * basis(level, omega)


@lru_cache
def basis_map(level: int) -> np.ndarray:
    """B [J / 4, BASIS_SIZE, BASIS_SIZE, 4] float32 over the upper hemisphere, as a disk (glsl/core/disk.glsl)."""
    p = np.linspace(-1.0, 1.0, BASIS_SIZE)
    omega = from_disk(np.stack(np.meshgrid(p, p), -1).reshape(-1, 2))
    values = basis(level, omega).reshape(BASIS_SIZE, BASIS_SIZE, -1, 4)
    return np.ascontiguousarray(np.moveaxis(values, 2, 0)).astype("f4")


def levels(sharpness: float, blend: float) -> list[tuple[int, float]]:
    """The level or the two levels for light up to a sharpness, with their shares (sum 1).

    Within `blend` below a level's limit (a ratio) its share goes over to the next.
    """
    for level, (limit, _) in enumerate(LEVELS[:-1]):
        if sharpness <= limit / blend:
            return [(level, 1.0)]
        if sharpness < limit:
            t = np.log(limit / sharpness) / np.log(blend)
            share = t * t * (3.0 - 2.0 * t)
            return [(level, share), (level + 1, 1.0 - share)]
    return [(len(LEVELS) - 1, 1.0)]
