"""Pictures of a weave as linear arrays: its drawdown as weavers draw it, and the cloth in its flat colours."""

from __future__ import annotations

import numpy as np

from .maps import sky
from .model import Weave

LEAST, MOST = 16, 96  # threads shown, each way
GROUND = 0.75  # the paper between the two pictures and the lines of the grid
GAP = 0.02  # how bright a hole is: what lies behind is not known


def weave_picture(weave: Weave, colors: tuple[np.ndarray, np.ndarray], side: int = 640) -> np.ndarray:
    """Drawdown and cloth beside each other, about `side` pixels high each; float32 [H, W, 3], linear Rec. 709.

    colors : ([ends, 3], [picks, 3]), of the threads in order, cyclic. The warp runs from top to bottom, the first pick is
    on top, as drafts are drawn.
    """
    picks, ends = (_shown(n, c) for n, c in zip(weave.drafted.structure, colors[::-1], strict=True))
    cell = max(side // max(picks, ends), 2)
    left = drawdown_picture(weave, colors, picks, ends, cell)
    right = cloth_picture(weave, colors, picks, ends, cell)
    between = np.full((left.shape[0], cell, 3), GROUND)
    return np.concatenate([left, between, right], 1).astype(np.float32)


def drawdown_picture(weave: Weave, colors, picks: int, ends: int, cell: int) -> np.ndarray:
    """[picks cell, ends cell, 3]: each crossing in the colour of the thread on top, warp marked by a line along it."""
    up = np.take(np.take(weave.drafted.drawdown, range(picks), 0, mode="wrap"), range(ends), 1, mode="wrap")
    warp, weft = (np.take(c, range(n), 0, mode="wrap") for c, n in zip(colors, (ends, picks), strict=True))
    cells = np.where(up[..., None], warp[None, :], weft[:, None])
    picture = np.repeat(np.repeat(cells, cell, 0), cell, 1)
    if cell >= 6:
        # Threads of one colour would show nothing, so the sides of the thread on top are darker.
        edge = (np.arange(cell) < max(cell // 8, 1)) | (np.arange(cell) >= cell - max(cell // 8, 1))
        dark = np.where(up[:, None, :, None], edge, edge[None, :, None, None]).reshape(picks * cell, ends * cell)
        picture = picture * np.where(dark, 0.45, 1.0)[..., None]
    return picture


def cloth_picture(weave: Weave, colors, picks: int, ends: int, cell: int) -> np.ndarray:
    """[picks cell, ends cell, 3]: the yarns in their colours, depths darker by the weave's occlusion."""
    tile = weave.tile()
    H, W = tile.system.shape
    of_picks, of_ends = tile.threads
    light = 1.0 - weave.occlusion * (1.0 - sky(tile))
    # Maps have the warp along their columns; drafts have it from top to bottom.
    along, across = ((np.arange(n * cell) + 0.5) / cell for n in (picks, ends))
    at = np.ix_((across / of_ends % 1.0 * H).astype(int), (along / of_picks % 1.0 * W).astype(int))
    system, thread = tile.system[at].T, tile.thread[at].T
    out = np.full((*system.shape, 3), GAP)
    for j, (place, n) in enumerate(((across[None, :], of_ends), (along[:, None], of_picks))):
        # The thread of the whole pattern is the one of that number in the repeat which is nearest to the place.
        number = thread + n * np.rint((place - thread - 0.5) / n).astype(int)
        out = np.where((system == j)[..., None], colors[j][number % len(colors[j])], out)
    return out * light[at].T[..., None]


def _shown(threads: int, colors: np.ndarray) -> int:
    """How many threads to show: whole repeats, at least 16, or as many as there is room for."""
    repeat = int(np.lcm(threads, len(colors)))
    return min(repeat * -(-LEAST // repeat), MOST)
