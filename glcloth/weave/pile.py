"""Cut pile: one repeat of velvet seen from above, whose tufts stand on their ends and lean this way and that.

A crossing of its draft is a tuft. Hairs of a tuft lean together, spread outward from its middle, and follow the nap, which
turns over some tufts. What a place shows is how its hairs lean; how much of each lean there is in the whole cloth is the
fabric's own business: leans are ranked, so that all from upright to the lowest are there in equal shares.   [own]
"""

from __future__ import annotations

import numpy as np

LOWEST = np.radians(35.0)  # from upright; the pile of Sadeghi et al. 2013, table II (F), leans 35 to 40 degrees
MIXED = 0.78  # of what a place shows: hairs cross, so every place shows all leans, and some of them more
NAP, TUFT, SPLAY, HAIR = 0.4, 0.6, 1.2, 0.5  # how much each counts in a lean
WAVES, LONGEST, SHORTEST = 48, 16.0, 4.0  # of the nap: how many, and their lengths in tufts
JITTER = 0.22  # of a spacing, how far tufts stand from their places
RAGGED = 0.16  # of a spacing, how far hairs of one tuft reach into the next
DEEP = 0.6  # of a spacing, how much lower the pile is between tufts


def pile_fields(tufts: tuple[int, int], pitch: float, v: np.ndarray, u: np.ndarray) -> tuple[np.ndarray, ...]:
    """The maps of a tile (system, thread, tilt, side, height), each [len(v), len(u)], at places v and u in tufts.

    tufts : (rows, columns) of the repeat, those along v and along u. pitch : cm from one to the next.

    system : 0 where hairs lean along u, 1 along v. tilt : radians, 55 to 90 degrees, negative where they rise along +u or +v.
    side : 0, for a pile has no side. height : cm.
    """
    rows, columns = tufts
    rng = np.random.default_rng(11)
    hairs = _white(rng, 4, len(v), len(u))
    there = np.stack(np.broadcast_arrays(u[None, :], v[:, None])) + RAGGED * hairs[2:]
    tuft, away = _tufts(rng, there, rows, columns)
    own = rng.normal(size=(2, rows, columns))[:, tuft[1], tuft[0]]
    outward = 2.0 * away
    lean = NAP * _nap(rng, v, u, rows, columns) + TUFT * own + SPLAY * outward + HAIR * hairs[:2]
    system = (np.abs(lean[1]) > np.abs(lean[0])).astype(np.int8)
    along = np.where(system == 1, lean[1], lean[0])
    tilt = np.empty(along.shape)
    for j in (0, 1):
        for sign in (-1.0, 1.0):
            mine = (system == j) & ((along < 0.0) == (sign < 0.0))
            tilt[mine] = -sign * (np.pi / 2 - LOWEST * _ranked(np.hypot(*lean[:, mine])))
    height = -DEEP * pitch * np.minimum(np.sum(outward * outward, 0), 1.5)
    return system, np.where(system == 1, tuft[0], tuft[1]), tilt, np.zeros(tilt.shape), height


def _white(rng: np.random.Generator, count: int, height: int, width: int) -> np.ndarray:
    """Independent values of mean 0 and deviation 1 for single hairs, [count, height, width]."""
    return rng.normal(size=(count, height, width)).clip(-2.0, 2.0)


def _tufts(rng: np.random.Generator, there: np.ndarray, rows: int, columns: int) -> tuple[np.ndarray, np.ndarray]:
    """The tuft that each place [2, ...] belongs to, (column, row), and the way from its middle in tufts, [2, ...] each.

    Tufts stand in rows, every second one half a spacing aside, as they are bound.
    """
    shift = JITTER * rng.uniform(-1.0, 1.0, (2, rows, columns))
    shift[0] += 0.25 * (-1.0) ** np.arange(rows)[:, None]
    cell = np.floor(there).astype(int)
    best = np.full(there.shape[1:], np.inf)
    tuft, away = np.zeros(there.shape, int), np.zeros(there.shape)
    for row in (-1, 0, 1):
        for column in (-1, 0, 1):
            at = cell + np.array([column, row])[:, None, None]
            number = at[0] % columns, at[1] % rows
            way = there - at - 0.5 - shift[:, number[1], number[0]]
            distance = np.sum(way * way, 0)
            nearer = distance < best
            np.copyto(best, distance, where=nearer)
            np.copyto(tuft, np.stack(number), where=nearer)
            np.copyto(away, way, where=nearer)
    return tuft, away


def _nap(rng: np.random.Generator, v: np.ndarray, u: np.ndarray, rows: int, columns: int) -> np.ndarray:
    """A smooth lean of deviation 1, [2, len(v), len(u)], that repeats after the whole: a sum of waves."""
    length, angle = rng.uniform(SHORTEST, LONGEST, WAVES), rng.uniform(0.0, 2.0 * np.pi, WAVES)
    phase = rng.uniform(0.0, 2.0 * np.pi, (2, 1, WAVES))
    a = 2.0 * np.pi * np.rint(columns / length * np.cos(angle)) / columns * u[:, None]
    b = 2.0 * np.pi * np.rint(rows / length * np.sin(angle)) / rows * v[:, None] + phase
    return np.sqrt(2.0 / WAVES) * (np.cos(b) @ np.cos(a).T - np.sin(b) @ np.sin(a).T)


def _ranked(values: np.ndarray) -> np.ndarray:
    """`values` [N] as their ranks, evenly between 0 and 1."""
    out = np.empty(values.shape)
    out[np.argsort(values, kind="stable")] = (np.arange(values.size) + 0.5) / max(values.size, 1)
    return out
