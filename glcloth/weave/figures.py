"""Figures of damask and lace as masks over the threads of one repeat: bool [picks, ends], drawn from curves."""

from __future__ import annotations

import numpy as np


def _plane(n: int, cx: float = 0.0, cy: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """Coordinates -1..1 of the crossings of a repeat of n threads about a middle, cyclic: (x [1, n], y [n, 1])."""
    t = 2.0 * (np.arange(n) + 0.5) / n - 1.0
    wrap = lambda d: (d + 1.0) % 2.0 - 1.0  # noqa: E731
    return wrap(t[None, :] - cx), wrap(t[:, None] - cy)


def flower(n: int, petals: int, inner: float, outer: float, cx: float = 0.0, cy: float = 0.0) -> np.ndarray:
    """A flower: its edge goes from `inner` between the petals to `outer` at their tips."""
    x, y = _plane(n, cx, cy)
    return np.hypot(x, y) < inner + (outer - inner) * np.abs(np.cos(0.5 * petals * np.arctan2(y, x)))


def ring(n: int, low: float, high: float, cx: float = 0.0, cy: float = 0.0) -> np.ndarray:
    """Between two circles."""
    x, y = _plane(n, cx, cy)
    r = np.hypot(x, y)
    return (low <= r) & (r < high)


def ogee(n: int, width: float) -> np.ndarray:
    """Two waved bands that part and meet, and make pointed fields."""
    x, y = _plane(n)
    return np.abs(np.abs(x) - 0.5 * (1.0 + np.cos(np.pi * y))) < width


def damask_figure(n: int = 80) -> np.ndarray:
    """A rosette in an ogee lattice, and a smaller flower where its bands meet."""
    rosette = flower(n, 8, 0.28, 0.52) & ~ring(n, 0.17, 0.22) & ~flower(n, 8, 0.02, 0.10)
    small = flower(n, 6, 0.10, 0.26, 1.0, 1.0) & ~ring(n, 0.06, 0.09, 1.0, 1.0)
    return (rosette | ogee(n, 0.07)) & ~ring(n, 0.27, 0.34, 1.0, 1.0) | small


def lace_cut(n: int = 96) -> np.ndarray:
    """Where lace has no thread: a net of square meshes on edge, flowers of cloth in it, and eyelets in these."""
    t = np.arange(n) + 0.5
    x, y = t[None, :], t[:, None]
    wrap = lambda d: (d + 4.0) % 8.0 - 4.0  # noqa: E731
    mesh = lambda shift: np.abs(wrap(x - shift)) + np.abs(wrap(y - shift)) < 2.9  # noqa: E731
    net = mesh(0.0) | mesh(4.0)
    out = net.copy()
    for cx, cy, size in ((0.0, 0.0, 1.0), (1.0, 1.0, 0.62)):
        cloth = flower(n, 6, 0.26 * size, 0.62 * size, cx, cy)
        # Eyelets: one in each petal, a ring of small ones about the heart.
        eyelets = np.zeros((n, n), bool)
        for k in range(6):
            angle = np.pi * k / 3.0
            at = 0.40 * size
            eyelets |= ring(n, 0.0, 0.10 * size, cx + at * np.cos(angle), cy + at * np.sin(angle))
        eyelets |= ring(n, 0.0, 0.08 * size, cx, cy)
        out = np.where(cloth, eyelets, out)
    return out
