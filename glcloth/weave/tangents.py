"""The far field: which tangents stand for a yarn's tilts, and what share of the cloth each has.

A tilt between two tangents counts for both, in proportion to its nearness (hat functions: linear interpolation, so the
shares of a place add up to 1). Their means are the weights; measured against many tangents, the cloth is within
3 to 6 % rms for tangents 1.6 gamma_s apart and 1 % for 0.8 (facts-weave.md 2).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .tile import Tile

APART = 1.6  # of gamma_s: distance of tangents
LEAST, MOST = 3, 16  # tangents of a yarn; two hats alone are off by half
_MIDDLES = (np.arange(2048) + 0.5) / 2048
NEGLIGIBLE = 1e-5  # share of the cloth below which a tangent is left out


class Tangents(NamedTuple):
    """Some tilts of a yarn, radians, ascending, [n], and their weights [n]: what share of the whole cloth each has."""

    tilts: np.ndarray
    weights: np.ndarray


class Between(NamedTuple):
    """Tilts written as places between tangents: the lower one's number, and the share of the next one, each of any shape."""

    lower: np.ndarray
    upper_share: np.ndarray


def places(low: float, high: float, gamma_s: float) -> np.ndarray:
    """Tilts from `low` to `high`, equally spaced, near enough for a surface lobe of width gamma_s; radians, [n]."""
    if high - low < 0.1 * gamma_s:
        return np.array([0.5 * (low + high)])
    n = min(max(1 + int(np.ceil((high - low) / (APART * gamma_s))), LEAST), MOST)
    # Floats lie flat in their middle, so a symmetric range needs a tangent at 0.
    n += n % 2 == 0 and low == -high
    return np.linspace(low, high, min(n, MOST - 1 if low == -high else MOST))


def between(tilt: np.ndarray, tilts: np.ndarray) -> Between:
    """`tilt` [...] among ascending `tilts` [n]; beyond the ends the end counts."""
    if len(tilts) == 1:
        return Between(np.zeros(np.shape(tilt), int), np.zeros(np.shape(tilt)))
    lower = np.clip(np.searchsorted(tilts, tilt, side="right") - 1, 0, len(tilts) - 2)
    share = (tilt - tilts[lower]) / (tilts[lower + 1] - tilts[lower])
    return Between(lower, np.clip(share, 0.0, 1.0))


def sums(at: Between, values: np.ndarray | float, n: int) -> np.ndarray:
    """[n]: for each tangent the sum of `values` times its hat."""
    values = np.broadcast_to(values, at.lower.shape)
    low = np.bincount(at.lower.ravel(), (values * (1.0 - at.upper_share)).ravel(), n + 1)[:n]
    return low + np.bincount(at.lower.ravel() + 1, (values * at.upper_share).ravel(), n + 1)[:n]


def tile_tangents(tile: Tile, system: int, gamma_s: float) -> Tangents:
    """The tangents of one yarn system of a cloth, from the tilts that occur in it.

    Their weights add up to the yarn's area a_j, the share of the cloth where it lies on top.
    """
    tilt = np.clip(tile.tilt[tile.system == system], -np.pi / 2, np.pi / 2)
    if not tilt.size:
        return Tangents(np.zeros(1), np.zeros(1))
    top = np.abs(tilt).max()
    return _kept(tilt, 1.0 / tile.tilt.size, places(-top, top, gamma_s))


def curve_tangents(angles: np.ndarray, lengths: np.ndarray, gamma_s: float) -> Tangents:
    """The tangents of a tangent curve, enough that the far field is the curve and not its samples; weights sum to 1.

    angles : radians, [n + 1], control angles. lengths : [n], of the segments, 0 for a jump.
    """
    lengths = np.asarray(lengths, float)
    parts = []
    for branch in np.split(np.arange(len(lengths)), np.flatnonzero(lengths == 0.0)):
        branch = branch[lengths[branch] > 0.0]
        if branch.size:
            # Nothing lies between the two sides of a jump, so each side has tangents of its own.
            tilt = np.stack([angles[i] + (angles[i + 1] - angles[i]) * _MIDDLES for i in branch])
            amount = np.broadcast_to(lengths[branch, None] / (lengths.sum() * _MIDDLES.size), tilt.shape)
            ends = angles[[*branch, branch[-1] + 1]]
            parts.append(_kept(tilt.ravel(), amount.ravel(), places(ends.min(), ends.max(), gamma_s)))
    tilts, which = np.unique(np.concatenate([part.tilts for part in parts]), return_inverse=True)
    return Tangents(tilts, np.bincount(which.ravel(), np.concatenate([part.weights for part in parts])))


def _kept(tilt: np.ndarray, amount: np.ndarray | float, tilts: np.ndarray) -> Tangents:
    weights = sums(between(tilt, tilts), amount, len(tilts))
    kept = weights > NEGLIGIBLE
    return Tangents(tilts[kept], weights[kept]) if kept.any() else Tangents(np.zeros(1), np.zeros(1))
