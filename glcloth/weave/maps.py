"""The maps of one repeat that make threads visible near by and leave the far cloth what it is.

L(x) = sum_t rel_t(x) w_t M P f / Q with Q and w_t of the whole weave: since the mean of every rel_t is 1, the mean of
near pictures is the microcylinder cloth, whatever the light (facts-weave.md 0 and 3).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .tangents import Between, between, sums
from .tile import Tile

LAY = 0.9  # how far the sides of a yarn turn away: 1 would be to the vertical
DIRECTIONS, STEPS = 12, 10  # of the search for horizons
REACH_YARNS = 1.6  # how far that search goes
LARGEST = 1 << 20  # texels for which horizons are searched at full resolution


@dataclass(frozen=True)
class Maps:
    """One repeat, warp along u (columns), weft along v (rows). T tangents in the order given.

    rel : [T, H, W], what share tangent t has at a place over its share of the whole cloth; its mean is 1.
    share : [2, H, W], sum over the yarn's tangents of w_t rel_t. Its mean is the yarn's area.
    roll : [2, H, W], sine of the angle by which the yarn's surface turns to the side (+v on the warp, +u on the weft),
    times share. Its mean under every tangent is 0.
    height : [H, W], metres, mean 0. hole : [H, W], 1 where there is no yarn.
    size : metres, (along u, along v).
    """

    rel: np.ndarray
    share: np.ndarray
    roll: np.ndarray
    height: np.ndarray
    hole: np.ndarray
    size: tuple[float, float]


def make_maps(
    tile: Tile,
    tilts: Sequence[np.ndarray],
    weights: Sequence[np.ndarray],
    flat: tuple[float, float],
    occlusion: float,
    dtype=np.float64,
) -> Maps:
    """The maps of a cloth for given tangents.

    tilts, weights : for warp and weft [n_j], radians, ascending; what share of the whole cloth each tangent has. Tilts that
    are not the tile's own (a published far field) are met by stretching the tile's tilts to their range.
    flat : height over width of the yarns' sections. occlusion : 0..1, how much darker the depths are. dtype : of rel.
    """
    H, W = tile.system.shape
    open_sky = sky(tile) if occlusion > 0.0 else np.ones((H, W))
    light = 1.0 - occlusion * (1.0 - open_sky)
    rel = np.empty((sum(map(len, tilts)), H, W), dtype)
    share, roll = np.zeros((2, H, W)), np.zeros((2, H, W))
    first = 0
    for j, (own, w) in enumerate(zip(tilts, weights, strict=True)):
        n, mine = len(own), tile.system == j
        at, lit = _places(tile, mine, own), light[mine]
        mean = sums(at, lit, n) / (H * W)
        found = mean > 0.0
        scale = np.where(found, 1.0 / np.where(found, mean, 1.0), 0.0)
        weighed = np.zeros(lit.shape)
        for t in range(n):
            layer = rel[first + t]
            # A tangent that occurs nowhere in the tile is spread over all of it, so that its mean is 1 as well.
            layer[...] = 0.0 if found[t] else 1.0
            if found[t]:
                hat = np.where(at.lower == t, 1.0 - at.upper_share, 0.0) + np.where(
                    at.lower == t - 1, at.upper_share, 0.0
                )
                layer[mine] = hat * lit * scale[t]
                weighed += w[t] * scale[t] * hat * lit
        share[j][mine] = weighed
        if tile.mixed:
            # Some of every lean everywhere; the depths are darker for these, too.
            for part, mean in ((rel[first : first + n], 1.0), (share[j], float(np.sum(w)))):
                part *= 1.0 - tile.mixed
                part += tile.mixed * mean * light / light.mean()
        roll[j][mine] = weighed * _even(_turned(tile.side[mine], flat[j]), at, lit, w * scale)
        first += n
    height = 0.01 * (tile.height - tile.height.mean())
    size = (0.01 * tile.size[0], 0.01 * tile.size[1])
    return Maps(rel, share, roll, height, (tile.system < 0).astype(float), size)


def _places(tile: Tile, mine: np.ndarray, tilts: np.ndarray) -> Between:
    """The tilts of a yarn's texels among `tilts`, stretched to their range."""
    tilt = np.clip(tile.tilt[mine], -np.pi / 2, np.pi / 2)
    there, here = np.abs(tilts).max(initial=0.0), np.abs(tilt).max(initial=0.0)
    tilt = tilt * (there / here) if here > 0.0 else tilt
    # A hair has no head: 85 degrees are nearer to -90 than to -50. Only a pile stands so steep.
    turned = tilt - np.sign(tilt) * np.pi
    past = np.maximum(tilt - tilts[-1], tilts[0] - tilt), np.maximum(turned - tilts[-1], tilts[0] - turned)
    return between(np.where(past[1] < np.maximum(past[0], 0.0), turned, tilt), tilts)


def _turned(side: np.ndarray, flat: float) -> np.ndarray:
    """Sine of the angle by which an elliptic section's normal turns, at `side` -1..1 across it."""
    return np.sin(LAY * np.arctan(flat * side / np.sqrt(np.maximum(1.0 - side * side, 1e-3))))


def _even(s: np.ndarray, at: Between, lit: np.ndarray, factor: np.ndarray) -> np.ndarray:
    """`s` less a sum of hats, so that its mean under every tangent is 0: no product with a lobe shifts the far field.

    Twist makes roll and tilt go together; with mean 0 over the yarn alone errors reach 8.6 % (facts-weave.md 3).
    The hats' products meet only their neighbours, so the matrix has three diagonals.
    """
    n, a, b = len(factor), 1.0 - at.upper_share, at.upper_share
    main = np.bincount(at.lower, lit * a * a, n + 1)[:n] + np.bincount(at.lower + 1, lit * b * b, n + 1)[:n]
    beside = np.bincount(at.lower, lit * a * b, n + 1)[:n]
    M = np.diag(main) + np.diag(beside[: n - 1], 1) + np.diag(beside[: n - 1], -1)
    mu = np.append(np.linalg.lstsq(factor[:, None] * M, factor * sums(at, lit * s, n), rcond=None)[0], 0.0)
    return s - a * mu[at.lower] - b * mu[at.lower + 1]


def sky(tile: Tile) -> np.ndarray:
    """[H, W]: how open each place is to the sky, 0..1: mean over 12 directions of 1 - sin^2(horizon), cosine-weighted."""
    height = tile.height
    halved = height.size > LARGEST
    if halved:
        height = _halved(height)
    H, W = height.shape
    du, dv = tile.size[0] / W, tile.size[1] / H
    # Texels are not square, so the search goes equally far in centimetres.
    far = REACH_YARNS * max(tile.size[0] / tile.threads[0], tile.size[1] / tile.threads[1])
    open_sky = np.zeros((H, W))
    for angle in 2.0 * np.pi * np.arange(DIRECTIONS) / DIRECTIONS:
        steps = far * np.linspace(0.06, 1.0, STEPS) ** 1.3
        shifts = {(round(s * np.sin(angle) / dv), round(s * np.cos(angle) / du)) for s in steps} - {(0, 0)}
        slope = np.zeros((H, W))
        for y, x in sorted(shifts):
            np.maximum(slope, (np.roll(height, (-y, -x), (0, 1)) - height) / np.hypot(x * du, y * dv), out=slope)
        open_sky += 1.0 / (1.0 + slope * slope)
    open_sky /= DIRECTIONS
    return np.repeat(np.repeat(open_sky, 2, 0), 2, 1) if halved else open_sky


def mip_levels(a: np.ndarray) -> list[np.ndarray]:
    """`a` [..., H, W] and its mip levels down to [..., 1, 1], each the mean of 2 x 2 texels of the one before.

    H and W are powers of two, so every level has the same mean. They are made here because drivers round half floats
    down: 0.2 % at the top of the chain (facts-weave.md 3).
    """
    levels = [a]
    while levels[-1].shape[-2:] != (1, 1):
        levels.append(_halved(levels[-1]))
    return levels


def _halved(a: np.ndarray) -> np.ndarray:
    """Means of 2 x 2 texels of the last two axes, [..., H, W] -> [..., H / 2, W / 2]; a side of 1 stays."""
    if a.shape[-2] > 1:
        a = 0.5 * (a[..., ::2, :] + a[..., 1::2, :])
    return 0.5 * (a[..., ::2] + a[..., 1::2]) if a.shape[-1] > 1 else a
