"""Long thin triangles in pieces, for a hierarchy of boxes.   [after Ernst and Greiner 2007, "Early split clipping"]

The box of a needle that lies across the axes is as large as all of a fan's: a ray would meet thousands of them. Each such
triangle is entered several times, by the boxes of pieces along it; what a ray is tested against stays the whole triangle.
"""

from __future__ import annotations

import numpy as np

MOST_BOXES = 64.0  # that a ray through the scene meets: with more, triangles are cut
PIECES = 24, 600_000  # for each triangle in the mean, and of all together, at most
MOST_CUTS = 255  # of one triangle


def pieces_of(positions: np.ndarray) -> np.ndarray | None:
    """Pieces of triangles [T, 3, 3]: uint32 [R, 4] of the triangle's number, the corner at its sharp end, and from where to where
    along it the piece goes, as bits of float32; None: none is worth cutting."""
    if len(positions) < MOST_BOXES:
        return None
    areas = _box_areas(positions.min(1), positions.max(1))
    whole = float(_box_areas(positions.min((0, 1)), positions.max((0, 1))))
    if not whole > 0.0 or areas.sum() <= MOST_BOXES * whole:
        return None
    edges = np.roll(positions, -1, 1).astype(float) - positions
    own = np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1)
    # The sum of areas / cuts is least where cuts grow as the root of what a cut can save.
    saved = np.sqrt(np.maximum(areas - 2.0 * own, 0.0))
    room = min(PIECES[0] * len(positions), PIECES[1])
    cuts = np.clip((room / max(saved.sum(), 1e-30) * saved).astype(int), 1, MOST_CUTS)
    sharp = (np.linalg.norm(edges, axis=2).argmin(1) + 2) % 3
    number = np.repeat(np.arange(len(positions)), cuts)
    place = np.arange(len(number)) - np.repeat(cuts.cumsum() - cuts, cuts)
    out = np.empty((len(number), 4), np.uint32)
    out[:, 0], out[:, 1] = number, sharp[number]
    ends = np.stack([place, place + 1], -1) / cuts[number, None]
    out[:, 2:] = ends.astype(np.float32).view(np.uint32)
    return out


def _box_areas(low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Half the surface of boxes."""
    x, y, z = np.moveaxis((high - low).astype(float), -1, 0)
    return x * y + y * z + z * x
