"""The six faces of a cube map as a set of directions with solid angles: where the reference method sums.

Faces and rows are in OpenGL's order (+x, -x, +y, -y, +z, -z; OpenGL 4.3 core, table 8.19), so an array
[6 n n, C] reshaped to [6, n, n, C] is what a cube texture takes.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from . import equirect


def _face_directions(s: np.ndarray, t: np.ndarray) -> np.ndarray:
    """Unnormalised directions [6, ..., 3] of face coordinates s, t in [-1, 1].   [OpenGL 4.3, table 8.19]"""
    one = np.ones_like(s)
    faces = [(one, -t, -s), (-one, -t, s), (s, one, t), (s, -one, -t), (s, -t, one), (-s, -t, -one)]
    return np.stack([np.stack(face, -1) for face in faces])


def directions(n: int) -> np.ndarray:
    """Unit directions [6 n n, 3] of the texel centres."""
    c = (np.arange(n) + 0.5) / n * 2 - 1
    t, s = np.meshgrid(c, c, indexing="ij")
    omega = _face_directions(s, t).reshape(-1, 3)
    return omega / np.linalg.norm(omega, axis=-1, keepdims=True)


@lru_cache(maxsize=4)
def solid_angles(n: int) -> np.ndarray:
    """Exact solid angles [6 n n] of the texels; they add up to 4 pi.

    The solid angle of the rectangle (0, 0)-(x, y) on the plane z = 1 is atan(x y / sqrt(1 + x^2 + y^2)).
    """
    e = np.linspace(-1, 1, n + 1)
    x, y = np.meshgrid(e, e, indexing="ij")
    corner = np.arctan2(x * y, np.sqrt(1 + x * x + y * y))
    face = corner[1:, 1:] - corner[1:, :-1] - corner[:-1, 1:] + corner[:-1, :-1]
    omega = np.tile(face.ravel(), 6)
    omega.setflags(write=False)
    return omega


def texel_of(omega: np.ndarray, n: int) -> np.ndarray:
    """Index [...] in 0 .. 6 n n - 1 of the texel that contains each direction omega [..., 3]."""
    x, y, z = omega[..., 0], omega[..., 1], omega[..., 2]
    a = np.abs(omega)
    major = np.argmax(a, axis=-1)
    m = np.take_along_axis(a, major[..., None], -1)[..., 0]
    face = 2 * major + (np.take_along_axis(omega, major[..., None], -1)[..., 0] < 0)
    s = np.choose(face, [-z, z, x, x, x, -x]) / m
    t = np.choose(face, [-y, -y, z, -z, -y, -y]) / m
    column = np.clip(((s + 1) / 2 * n).astype(int), 0, n - 1)
    row = np.clip(((t + 1) / 2 * n).astype(int), 0, n - 1)
    return (face * n + row) * n + column


@lru_cache(maxsize=2)
def _texel_of_map(height: int, width: int, n: int) -> np.ndarray:
    index = texel_of(equirect.texel_directions(height, width), n).astype(np.int32).ravel()
    index.setflags(write=False)
    return index


def average_map(radiance: np.ndarray, n: int) -> np.ndarray:
    """Average radiance [6 n n, 3] of an equirectangular map over the texels; the integral over the sphere is kept.

    Radiance up to 8 times the mean is averaged with its own weights (a constant map stays constant to the last bit);
    the excess of small lamps above that is deposited by its flux, so none is lost between texels.
    """
    height, width = radiance.shape[:2]
    # About four samples across a cube texel: more cost time, fewer leave steps.
    fine = max(8 * n, 16)
    if height > fine * 2:
        radiance, (height, width) = equirect.downsample(radiance, fine * 2, fine * 4), (fine * 2, fine * 4)
    exact = equirect.total(radiance)
    repeat = max(-(-fine // height), 1)
    values = radiance.astype(np.float64)
    if repeat > 1:
        values = np.repeat(np.repeat(values, repeat, 0), repeat, 1)
        height, width = values.shape[:2]
    index = _texel_of_map(height, width, n)
    weight = np.repeat(equirect.row_solid_angles(height, width), width)
    omega = solid_angles(n)
    count = len(omega)
    covered = np.bincount(index, weight, count)
    limit = 8 * exact / (4 * np.pi)
    result = np.empty((count, 3))
    for c in range(3):
        channel = values[..., c].ravel()
        smooth = np.minimum(channel, limit[c])
        mean = np.bincount(index, weight * smooth, count) / np.maximum(covered, 1e-300)
        flux = np.bincount(index, weight * (channel - smooth), count)
        mean_flux = exact[c] - flux.sum()
        got = float(mean @ omega)
        result[:, c] = mean * (mean_flux / got if got > 0 else 1.0) + flux / omega
    return result


def average_gaussians(axis: np.ndarray, sharpness: np.ndarray, amplitude: np.ndarray, n: int) -> np.ndarray:
    """Average radiance [6 n n, 3] over the texels of spherical Gaussians: axis [K, 3], sharpness [K], amplitude [K, 3].

    Each lobe is integrated by Gauss-Legendre points, as many as its width asks for, and scaled to its exact integral
    2 pi (1 - exp(-2 sharpness)) / sharpness.
    """
    centres, omega = directions(n), solid_angles(n)
    result = np.zeros((6 * n * n, 3))
    for xi, lam, mu in zip(axis, sharpness, amplitude, strict=True):
        exact = 4 * np.pi if lam < 1e-8 else -2 * np.pi * np.expm1(-2 * lam) / lam
        # A texel is at most 2 / n wide on the face; the lobe falls to 1/e within sqrt(2 / lam).
        points = int(np.clip(np.ceil(2 + 3 * (2 / n) / np.sqrt(2 / max(lam, 1e-8))), 2, 24))
        reach = np.sqrt(2 * 40 / max(lam, 1e-8)) + 2 * np.sqrt(2) / n
        near = (
            np.flatnonzero(centres @ xi > np.cos(min(reach, np.pi)) - 1e-12) if reach < np.pi else np.arange(6 * n * n)
        )
        flux = _texel_integrals(xi, lam, near, n, points)
        got = flux.sum()
        if got <= 0.5 * exact:
            # Narrower than the quadrature can see: all of it lies in the texel of its axis.
            near, flux, got = texel_of(np.asarray(xi)[None], n), np.ones(1), 1.0
        result[near] += (flux * (exact / got) / omega[near])[:, None] * mu
    return result


def _texel_integrals(xi: np.ndarray, lam: float, texels: np.ndarray, n: int, points: int) -> np.ndarray:
    """Integrals over the given texels of exp(lam (omega . xi - 1)), points^2 Gauss-Legendre nodes each."""
    x, w = np.polynomial.legendre.leggauss(points)
    face, row, column = texels // (n * n), texels // n % n, texels % n
    s = ((column[:, None] + 0.5) + 0.5 * x) / n * 2 - 1
    t = ((row[:, None] + 0.5) + 0.5 * x) / n * 2 - 1
    # omega . xi on a face is linear in s and t before normalisation, so no direction need be formed.
    base = _face_directions(np.zeros(1), np.zeros(1))[:, 0] @ xi
    along_s = _face_directions(np.ones(1), np.zeros(1))[:, 0] @ xi - base
    along_t = _face_directions(np.zeros(1), np.ones(1))[:, 0] @ xi - base
    r2 = 1 + (s * s)[:, None, :] + (t * t)[:, :, None]
    dot = base[face, None, None] + (along_s[face, None] * s)[:, None, :] + (along_t[face, None] * t)[:, :, None]
    value = np.exp(lam * (dot / np.sqrt(r2) - 1)) / (r2 * np.sqrt(r2))
    return np.einsum("i,j,tij->t", w, w, value) / (n * n)


def deposit(omega: np.ndarray, irradiance: np.ndarray, n: int) -> np.ndarray:
    """Radiance [6 n n, 3] of directional lights (omega [S, 3], irradiance [S, 3]), each spread over its texel."""
    result = np.zeros((6 * n * n, 3))
    if len(omega):
        index = texel_of(np.asarray(omega, float), n)
        np.add.at(result, index, np.asarray(irradiance, float) / solid_angles(n)[index, None])
    return result
