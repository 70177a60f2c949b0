"""Coarser and coarser versions of a map that repeats, side by side in one picture.   [own]

As long as yarns have several texels the versions stand a quarter of a mip level apart, and a pixel reads the one that is nearest
to its own size, with one bilinear fetch: on a software rasteriser that takes a third of the time of two mip levels. Further on
they are mip levels, of which it reads two: texels that are out of step with the yarns would make patterns of their own there.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from .maps import mip_levels

PER_OCTAVE = 4  # as level_number of glsl/core/footprint.glsl has it
FINE = 1 << 16  # texels of the largest mip level with versions between it and the next: of larger ones they cost memory
MARGIN = 1  # texels about each, of what comes after the repeat's ends


@dataclass(frozen=True)
class Levels:
    """Where the versions of a map [H, W] stand. whole, end : the mip levels from which, and up to which, they are a quarter of
    a level apart; all others are a whole one.

    lods, sizes, places : of each, its mip level, (h, w) and the (row, column) of its first texel.
    shape : of the picture, (rows, columns).
    """

    whole: int
    end: int
    lods: tuple[float, ...]
    sizes: tuple[tuple[int, int], ...]
    places: tuple[tuple[int, int], ...]
    shape: tuple[int, int]

    @property
    def rects(self) -> np.ndarray:
        """[levels, 4]: where each begins, u and v, and its sides, of the picture's."""
        rows, columns = self.shape
        return np.array(
            [
                (column / columns, row / rows, w / columns, h / rows)
                for (h, w), (row, column) in zip(self.sizes, self.places, strict=True)
            ],
            "f4",
        )


@lru_cache(maxsize=8)
def levels_of(height: int, width: int, end: int) -> Levels:
    """The versions of maps of this size, powers of two, down to one texel; `end` : as Levels has it."""
    octaves, whole = int(np.log2(max(height, width))), 0
    end = min(max(end, 0), octaves)
    while whole < end and height * width >> 2 * whole > FINE:
        whole += 1
    between = np.arange(PER_OCTAVE * (end - whole)) / PER_OCTAVE + whole
    lods = [*range(whole), *between, *range(end, octaves + 1)]
    sizes = tuple((max(round(height * 0.5**lod), 1), max(round(width * 0.5**lod), 1)) for lod in lods)
    places, shelf, right, below = [], 0, 0, 0
    columns = width + max(round(width * 0.5 ** (1.0 / PER_OCTAVE)), 1) + 4 * MARGIN
    for h, w in sizes:  # on shelves, from the largest on
        if right + w + 2 * MARGIN > columns:
            shelf, right = below, 0
        places.append((shelf + MARGIN, right + MARGIN))
        right += w + 2 * MARGIN
        below = max(below, shelf + h + 2 * MARGIN)
    return Levels(whole, end, tuple(lods), sizes, tuple(places), (below, columns))


def side_by_side(maps: np.ndarray, levels: Levels, kind: str = "f4") -> np.ndarray:
    """Maps [..., H, W] in all their versions, [..., rows, columns]; each version has the mean of the map."""
    whole = mip_levels(maps)
    picture = np.zeros((*maps.shape[:-2], *levels.shape), kind)
    for lod, (h, w), (row, column) in zip(levels.lods, levels.sizes, levels.places, strict=True):
        level = _resampled(whole[int(lod)], (h, w))
        picture[..., row - 1 : row + h + 1, column - 1 : column + w + 1] = np.pad(
            level, [(0, 0)] * (maps.ndim - 2) + [(MARGIN, MARGIN)] * 2, "wrap"
        )
    return picture


def _resampled(a: np.ndarray, size: tuple[int, int]) -> np.ndarray:
    """Means of `a` [..., H, W] over the areas of other texels, up to twice as large."""
    return _along(_along(a, size[1], -1), size[0], -2)


def _along(a: np.ndarray, wanted: int, axis: int) -> np.ndarray:
    """The same along one axis."""
    count = a.shape[axis]
    if count == wanted:
        return a
    edges = np.arange(wanted + 1) * (count / wanted)
    first, out = np.floor(edges[:-1] + 1e-9).astype(int), None
    for place in (first, first + 1, first + 2):  # a texel has parts in three others at most
        part = np.minimum(edges[1:], place + 1) - np.maximum(edges[:-1], place)
        weight = (np.maximum(part, 0.0) * (wanted / count)).astype(a.dtype)
        term = np.take(a, np.minimum(place, count - 1), axis)
        term *= weight if axis == -1 else weight[:, None]
        out = term if out is None else np.add(out, term, out=out)
    assert out is not None
    return out
