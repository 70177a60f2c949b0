"""The colours of single threads: what they add up to from afar, and a map of them near by."""

from __future__ import annotations

import numpy as np

from .tile import Tile

LARGEST = 1024  # texels a side of the map


def thread_shares(tile: Tile, system: int) -> np.ndarray:
    """[threads of the repeat]: what share of the cloth each end (system 0) or pick (1) covers."""
    picks, ends = tile.threads
    mine = tile.system == system
    return np.bincount(tile.thread[mine], minlength=(ends, picks)[system]) / mine.size


def mean_color(tile: Tile, system: int, colors: np.ndarray) -> np.ndarray:
    """[3]: the colour of a yarn system from afar, `colors` [n, 3] being its threads' in order, cyclic.

    Each thread counts as much as it shows, over the least common repeat of structure and colours.
    """
    shares = thread_shares(tile, system)
    if not shares.any():
        return colors.mean(0)
    n = int(np.lcm(len(shares), len(colors)))
    shown = np.bincount(np.arange(n) % len(colors), shares[np.arange(n) % len(shares)], len(colors))
    return shown @ colors / shown.sum()


def color_map(
    tile: Tile, colors: tuple[np.ndarray, np.ndarray], share: np.ndarray, largest: int = LARGEST
) -> tuple[np.ndarray, tuple[float, float]]:
    """The colours of both yarns over the least common repeat of structure and colours.

    colors : ([ends, 3], [picks, 3]), cyclic. share : [2, H, W] of the tile's Maps. Returns (map, size): float32
    [2, H', W', 4], colour times share and share, so that rgb / a of any filtered texel is the yarn's colour there; sides
    are powers of two, at most `largest`; size is (along u, along v) in metres. The mean's rgb / a is `mean_color`.
    """
    picks, ends = tile.threads
    H, W = tile.system.shape
    copies = [int(np.lcm(n, len(c)) // n) for n, c in zip((ends, picks), colors, strict=True)]
    sides = [min(1 << int(np.ceil(np.log2(side * k))), largest) for side, k in zip((H, W), copies, strict=True)]
    # Places in the common repeat, in copies of the tile; which copy, and which texel of it.
    row, column = ((np.arange(side) + 0.5) / side * k for side, k in zip(sides, copies, strict=True))
    at = np.ix_(((row % 1.0) * H).astype(int), ((column % 1.0) * W).astype(int))
    out = np.empty((2, *sides, 4), np.float32)
    for j, (place, threads) in enumerate(((row[:, None], ends), (column[None, :], picks))):
        thread = tile.thread[at]
        # A yarn wider than its strip reaches into the next copy: it is the thread nearest to the place.
        local = (place % 1.0) * threads
        beyond = np.rint((local - thread - 0.5) / threads).astype(int)
        number = (thread + threads * (np.floor(place).astype(int) + beyond)) % len(colors[j])
        own = share[j][at]
        out[j, ..., :3], out[j, ..., 3] = colors[j][number] * own[..., None], own
        shown = out[j].reshape(-1, 4).mean(0, dtype=float)
        # Texels are sampled, not integrated: the rest is put right, so that the far field holds.
        wanted = mean_color(tile, j, colors[j]) * shown[3]
        out[j, ..., :3] *= np.where(shown[:3] > 0.0, wanted / np.maximum(shown[:3], 1e-30), 1.0).astype(np.float32)
    return out, (0.01 * tile.size[0] * copies[1], 0.01 * tile.size[1] * copies[0])
