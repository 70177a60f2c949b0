"""Floats: how long each yarn stays on one side of the cloth, and the path it takes between."""

from __future__ import annotations

import numpy as np


def runs(up: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Split cyclic rows of crossings into runs of equal side.

    up : bool [N, n], True where the yarn is on top.
    Returns (length, place), int [N, n]: the length of the run each crossing lies in, and how many crossings of the run
    come before it. A row that never changes sides has length 0: it is never bound.
    """
    N, n = up.shape
    length, place = np.zeros((N, n), int), np.zeros((N, n), int)
    k = np.arange(n)
    for row, (L, P) in zip(up, zip(length, place, strict=True), strict=True):
        starts = np.flatnonzero(row != np.roll(row, 1))
        if not starts.size:
            continue
        mine = np.searchsorted(starts, k, side="right") - 1  # -1: the run that comes round from the end
        ends = np.append(starts[1:], starts[0] + n)
        L[:] = (ends - starts)[mine]
        P[:] = (k - starts[mine]) % n
    return length, place


def float_lengths(drawdown: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Lengths of all floats of one repeat, in crossings: (of the warp on the face, of the weft on the face), ascending.

    drawdown : bool [picks, ends]. A thread that is never bound counts as one float of the whole repeat.
    """
    out = []
    for up in (drawdown.T, ~drawdown):
        length, place = runs(up)
        bound = length[:, 0] > 0
        never = np.full(int((up[:, 0] & ~bound).sum()), up.shape[1])
        out.append(np.sort(np.concatenate([length[up & (place == 0) & bound[:, None]], never])))
    return out[0], out[1]


def path(up: np.ndarray, x: np.ndarray, bow: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The axis of each yarn of a system along its length.

    up : bool [N, n]. x : [W], places along the yarn in crossings, 0 to n. bow : 0 floats lie flat, 1 they are one arc.
    Returns (height, slope, dive), each [N, W]: height -1..1; slope -1..1 of the largest, positive where the yarn rises
    along x; dive 0..1, 0 in the middle of a float and 1 where the yarn changes sides.

    In a run of n crossings, t = -1..1 from one change of sides to the next; the bend at each end takes
    e = 1/2 + bow (n - 1)/2 crossings, and q = min(1, (1 - |t|) n / 2 e) runs from 0 at the change to 1 where the yarn
    lies flat: height sin(pi q / 2), slope cos(pi q / 2).   [facts-weave.md 2; n = 1: the sine of Peirce 1937]
    """
    length, place = runs(up)
    k = np.minimum(x.astype(int), up.shape[1] - 1)
    n, side = length[:, k], np.where(up[:, k], 1.0, -1.0)
    bound = n > 0
    n = np.maximum(n, 1)
    t = np.where(bound, 2.0 * (place[:, k] + (x - k)) / n - 1.0, 0.0)
    e = 0.5 + bow * (n - 1) / 2.0
    q = np.where(bound, np.minimum(1.0, (1.0 - np.abs(t)) * n / (2.0 * e)), 1.0)
    return side * np.sin(np.pi / 2 * q), -side * np.sign(t) * np.cos(np.pi / 2 * q), np.abs(t)
