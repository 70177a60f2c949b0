"""One repeat of a cloth seen from above: which yarn lies on top at each place, how it tilts, and how high it is.

Warp runs along u (columns of the maps), weft along v (rows); ends are counted along v, picks along u. Yarn 0 is the
warp, 1 the weft. Geometry after Peirce 1937, "The Geometry of Cloth Structure": crimp heights share the sum of the
yarns' heights; sections are ellipses.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from .draft import Draft
from .floats import path
from .pile import MIXED, pile_fields

TEXELS = 32  # a yarn, in large repeats
SMALLEST, LARGEST = 256, 1024  # texels a side; a larger tile takes seconds, so it is made on request only
REACH = 8  # neighbours on either side that may lie over a place


@dataclass(frozen=True)
class Shape:
    """The measures of a weave: everything that its geometry depends on. Pairs are (warp, weft).

    ends_per_cm, picks_per_cm : the sett. width : yarn width over mean spacing. flat : height over width of the section.
    crimp : the warp's share of the sum of crimp heights. bow : 0 floats lie flat, 1 they are one arc. twist : radians,
    positive Z. pinch : how much narrower a yarn is where it changes sides. steepest : largest tilt, radians, or None for
    what crimp and sett give.
    """

    draft: Draft
    ends_per_cm: float
    picks_per_cm: float
    width: tuple[float, float]
    flat: tuple[float, float]
    crimp: float
    bow: tuple[float, float]
    twist: tuple[float, float]
    pinch: tuple[float, float]
    steepest: tuple[float, float] | None = None

    @property
    def pitch(self) -> tuple[float, float]:
        """cm from end to end and from pick to pick, in the mean."""
        return 1.0 / self.ends_per_cm, 1.0 / self.picks_per_cm

    @property
    def heights(self) -> tuple[float, float]:
        """cm, heights of the two yarns' sections, b_j = flat_j width_j pitch_j."""
        return tuple(f * w * p for f, w, p in zip(self.flat, self.width, self.pitch, strict=True))

    @property
    def crimps(self) -> tuple[float, float]:
        """cm, how far each yarn's axis travels up and down: h_1 + h_2 = b_1 + b_2.   [Peirce 1937]"""
        total = sum(self.heights)
        return self.crimp * total, (1.0 - self.crimp) * total

    @property
    def largest_tilts(self) -> tuple[float, float]:
        """Radians, the slope of each axis where it changes sides: tan u_1 = pi h_1 / (2 p_2), and the same exchanged."""
        if self.steepest is not None:
            return self.steepest
        (h_1, h_2), (p_1, p_2) = self.crimps, self.pitch
        return float(np.arctan(np.pi * h_1 / (2 * p_2))), float(np.arctan(np.pi * h_2 / (2 * p_1)))


@dataclass(frozen=True)
class Tile:
    """Maps [H, W] of one repeat of the structure, sampled at the middles of their texels.

    system : int8, the yarn on top: 0 warp, 1 weft, -1 a hole. thread : which end or pick of the repeat.
    tilt : radians, positive where the fibres go down along the yarn, twist included. side : -1..1 across the yarn, toward
    +v on the warp and +u on the weft. height : cm above the cloth's middle plane.
    size : (along u, along v) of the repeat in cm. threads : (picks, ends) of the repeat.
    mixed : what share of a place shows all leans alike, as hairs of a pile do that cross each other.
    """

    system: np.ndarray
    thread: np.ndarray
    tilt: np.ndarray
    side: np.ndarray
    height: np.ndarray
    size: tuple[float, float]
    threads: tuple[int, int]
    mixed: float = 0.0


def tile_size(picks: int, ends: int) -> tuple[int, int]:
    """(H, W) of the maps of a repeat: powers of two, so that means of mip levels are exact; about 32 texels a yarn."""
    sides = (2 ** round(np.log2(TEXELS * n)) for n in (ends, picks))
    H, W = (int(min(max(side, SMALLEST), LARGEST)) for side in sides)
    return H, W


@lru_cache(maxsize=4)
def make_tile(shape: Shape, size: tuple[int, int] | None = None) -> Tile:
    """The cloth of `shape` seen from above, `size` = (H, W) texels (`tile_size` by default).

    At each texel the highest of all yarns that pass there wins, so floats, crossings, gaps and areas need no cases. Where
    few crossings differ from those of the tile before, only the strips about their threads are made anew.
    """
    picks, ends = shape.draft.structure
    draft = shape.draft.sized(picks, ends)
    H, W = size or tile_size(picks, ends)
    v, u = (np.arange(H) + 0.5) * ends / H, (np.arange(W) + 0.5) * picks / W
    rows, columns, before = np.arange(H), np.arange(W), _latest.get((H, W))
    changed = None if before is None else _rewoven(shape, draft, *before[:2])
    if before is None or changed is None:
        fields = _seen(shape, draft, v, u)
    else:
        fields = tuple(a.copy() for a in before[2])
        warp, weft = (
            _Threads(draft.warp_spacing, draft.warp_thickness),
            _Threads(draft.weft_spacing, draft.weft_thickness),
        )
        rows = rows[warp.touched(v, changed[0], 0.5 * shape.width[0])]
        columns = columns[weft.touched(u, changed[1], 0.5 * shape.width[1])]
        for field, high, low in zip(
            fields, _seen(shape, draft, v[rows], u), _seen(shape, draft, v, u[columns]), strict=True
        ):
            field[rows], field[:, columns] = high, low
    while len(_latest) > 1 and (H, W) not in _latest:
        del _latest[next(iter(_latest))]
    _latest[H, W] = shape, draft, fields
    p_1, p_2 = shape.pitch
    return Tile(*fields, (picks * p_2, ends * p_1), (picks, ends), MIXED if draft.pile else 0.0)


# The last tile of each of two sizes (H, W), of a whole weave and of a sketch of it: its shape, one repeat of its draft, its maps.
_latest: dict[tuple[int, int], tuple[Shape, Draft, tuple[np.ndarray, ...]]] = {}


def _rewoven(shape: Shape, draft: Draft, old: Shape, old_draft: Draft) -> tuple[np.ndarray, np.ndarray] | None:
    """Which ends and which picks of one repeat run otherwise than in an older shape, bool; None: more than that differs."""
    if draft.pile or replace(old, draft=shape.draft) != shape or draft.drawdown.shape != old_draft.drawdown.shape:
        return None
    of_threads = ["cut", *(f"{system}_{what}" for system in ("warp", "weft") for what in ("spacing", "thickness"))]
    if not all(np.array_equal(getattr(draft, name), getattr(old_draft, name)) for name in of_threads):
        return None
    differ = draft.drawdown != old_draft.drawdown
    return differ.any(0), differ.any(1)


def _seen(shape: Shape, draft: Draft, v: np.ndarray, u: np.ndarray) -> tuple[np.ndarray, ...]:
    """The maps of a tile (system, thread, tilt, side, height) at places v and u, in mean spacings."""
    if draft.pile:
        return pile_fields(draft.drawdown.shape[::-1], min(shape.pitch), v, u)
    picks, ends = draft.drawdown.shape
    warp, weft = _Threads(draft.warp_spacing, draft.warp_thickness), _Threads(draft.weft_spacing, draft.weft_thickness)
    layers = [
        _highest(shape, 0, warp, v, draft.drawdown.T, weft.crossing(u)),
        _highest(shape, 1, weft, u, ~draft.drawdown, warp.crossing(v)),
    ]
    layers[1] = tuple(a.T for a in layers[1])
    weft_wins = layers[1][0] > layers[0][0]
    height, thread, tilt, side = (np.where(weft_wins, b, a) for a, b in zip(*layers, strict=True))
    hole = np.isneginf(height)
    if draft.cut is not None:
        hole |= draft.cut[np.ix_(_number(weft.crossing(u), picks), _number(warp.crossing(v), ends))].T
    system = np.where(hole, -1, weft_wins).astype(np.int8)
    floor = -0.5 * sum(shape.heights)
    return system, thread, np.where(hole, 0.0, tilt), np.where(hole, 0.0, side), np.where(hole, floor, height)


def _number(crossing: np.ndarray, n: int) -> np.ndarray:
    """The thread of each place in crossings."""
    return np.minimum(crossing.astype(int), n - 1)


class _Threads:
    """Where the threads of one system lie across it, in mean spacings: 0 to n, cyclic."""

    def __init__(self, spacing: np.ndarray, thickness: np.ndarray):
        self.edges = np.concatenate([[0.0], np.cumsum(spacing / spacing.mean())])
        self.edges[-1] = len(spacing)
        self.middles = 0.5 * (self.edges[:-1] + self.edges[1:])
        self.relative = thickness / thickness.mean()

    def crossing(self, x: np.ndarray) -> np.ndarray:
        """Places x in crossings: k at the edge before thread k, k + 1 at the edge behind it."""
        return np.interp(x, self.edges, np.arange(len(self.edges)))

    def own(self, x: np.ndarray) -> np.ndarray:
        """The thread in whose strip each place x lies."""
        return np.minimum(np.searchsorted(self.edges, x, side="right") - 1, len(self.middles) - 1)

    def touched(self, x: np.ndarray, threads: np.ndarray, half: float) -> np.ndarray:
        """Which places x some of the `threads` (bool [n]) may cover; `half`: half a mean thread's width."""
        reach = self.neighbours(half * self.relative)
        near = np.zeros(len(threads), bool)
        for offset in range(-reach, reach + 1):
            near |= np.roll(threads, offset)
        return near[self.own(x)]

    def neighbours(self, half: np.ndarray) -> int:
        """How many threads away one may be that still lies over a thread's own strip; `half`: their half widths."""
        n = len(self.middles)
        for reach in range(REACH):
            at = np.arange(n) + reach + 1
            behind = self.middles[at % n] + n * (at // n) - half[at % n] >= self.edges[1:]
            at = np.arange(n) - reach - 1
            before = self.middles[at % n] + n * (at // n) + half[at % n] <= self.edges[:-1]
            if behind.all() and before.all():
                return reach
        return REACH


def _highest(shape: Shape, j: int, threads: _Threads, across: np.ndarray, up: np.ndarray, along: np.ndarray):
    """The highest yarn of system j: (height, thread, tilt, side), each [across, along]; height -inf where there is none.

    across : places across the yarns, in mean spacings. along : places along them, in crossings. up : bool [threads, n].
    """
    n = len(up)
    own = threads.own(across)
    half = 0.5 * shape.width[j] * threads.relative
    reach = threads.neighbours(half)
    # Only threads that pass here have a path; `number` is a thread's row in it.
    used = np.unique((own[:, None] + np.arange(-reach, reach + 1)) % n)
    number = np.zeros(n, int)
    number[used] = np.arange(len(used))
    axis, slope, dive = path(up[used], along, shape.bow[j])
    narrow = 1.0 - shape.pinch[j] * np.clip((dive - 0.4) / 0.6, 0.0, 1.0) ** 2
    # Positive tilt goes down along the yarn. Z fibres rise toward +y of the yarn's own frame: +v of the warp, -u of the weft.
    tilt_of_axis = -shape.largest_tilts[j] * slope
    twist = -shape.twist[j] if j == 0 else shape.twist[j]
    crimp, height = shape.crimps[j], shape.heights[j]
    best = [np.full((len(across), len(along)), fill) for fill in (-np.inf, 0, 0.0, 0.0)]
    for offset in range(-reach, reach + 1):
        index = own + offset
        i = index % n
        k = number[i]
        middle = threads.middles[i] + n * (index // n)
        y = ((across - middle) / half[i])[:, None] / narrow[k]
        inside = np.abs(y) < 1.0
        bulge = np.sqrt(np.maximum(1.0 - y * y, 0.0)) * (0.5 * height * threads.relative[i])[:, None]
        z = np.where(inside, 0.5 * crimp * axis[k] + bulge, -np.inf)
        wins = z > best[0]
        for a, b in zip(best, (z, i[:, None], tilt_of_axis[k] + twist * y, y), strict=True):
            np.copyto(a, b, where=wins)
    return tuple(best)
