"""Where hairs stand on cloth: at places fixed in UV, and of these the ones near an edge of the cloth as a camera sees it.   [own]

In each cell of a lattice over the UVs stands one hair, at a place and with a shape that the cell's numbers say, so that a hair
stays where it is whatever the camera does. Only hairs near an outline of the cloth or near its rim can be seen beyond it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from .camera import Camera
from .mesh import Mesh

REACH = 4.0  # hair lengths from an outline on which the surface turns away: so far hairs may stand out beyond it
RIM_REACH = 1.2  # from a rim, where it ends
MOST = 60_000  # hairs of a picture; where there would be more, fewer and wider ones stand for them
MOST_POINTS = 40_000  # of outlines
MOST_CELLS = (
    1 << 24
)  # of a lattice that are looked through: where UVs are so large that there were more, hairs are fewer
CELLS_AT_A_TIME = 1 << 20
FINEST = 2.5  # hairs have at least so much of a pixel's width as 1 / FINEST: thinner ones are fewer and wider instead
FADE = 0.25  # of the hairs' numbers, over which those that are left out fade
RANDOM = 8  # numbers a hair
GOLDEN = np.uint64(0x9E3779B97F4A7C15)


@dataclass(frozen=True)
class Hairs:
    """Hairs of a mesh, N of them.

    triangle : [N] of the mesh. weights : [N, 2] barycentric, of its second and third corner. random : [N, 8] from 0 to 1.
    width : [N] how much wider each is drawn than it is; 0: not at all. length : [N] how long it is of its whole length.
    side : [N] of the cloth, 0 front, 1 back.
    """

    triangle: np.ndarray
    weights: np.ndarray
    random: np.ndarray
    width: np.ndarray
    length: np.ndarray
    side: np.ndarray

    def __len__(self) -> int:
        return len(self.triangle)


NONE = Hairs(np.zeros(0, int), np.zeros((0, 2)), np.zeros((0, RANDOM)), np.zeros(0), np.zeros(0), np.zeros(0, int))


def hairs_in_view(
    mesh: Mesh,
    rim: np.ndarray,
    metres: float,
    camera: Camera,
    size: tuple[int, int],
    density: float,
    length: float,
    diameter: float,
    far: float,
    closed: Callable[[np.ndarray], np.ndarray] | None = None,
) -> Hairs:
    """The hairs that may stand out beyond the outline of a cloth.

    rim : [N, 2, 3] where it ends, as its `rim_edges`. metres : of a UV unit. density : hairs in a square metre.
    length, diameter : metres. far : metres of cloth in a pixel from which on there are none.
    closed : whether there is cloth at UVs [N, 2], None: everywhere.
    """
    view = _View(mesh, camera, size, length)
    inside = np.flatnonzero(view.inside & (view.pixel[mesh.triangles].min(1) < far))
    (outlines, sides), rims = _outlines(mesh, view, inside, length), _rims(rim, view, far, length)
    near = [
        _Near(points, reach * length, side)
        for points, reach, side in ((outlines, REACH, sides), (rims, RIM_REACH, None))
        if len(points)
    ]
    if not near or not len(inside):
        return NONE
    most = (1.0 + FADE) * FINEST * diameter / max(float(view.pixel[mesh.triangles[inside]].min()), 1e-9)
    triangle, weights, random = _roots(mesh, metres, _pieces(mesh, inside, near), density, most)
    place = _at(mesh.positions[mesh.triangles[triangle]].astype(float), weights)
    closeness, shows = _closeness(near, place)
    width = shown_width(view.pixel_at(place), diameter, random[:, 7])
    width *= np.clip(2.5 - 2.5 * view.pixel_at(place) / far, 0.0, 1.0)
    if closed is not None:
        assert mesh.uv is not None
        width = np.where(closed(_at(mesh.uv[mesh.triangles[triangle]].astype(float), weights)), width, 0.0)
    long = np.clip(4.0 * closeness, 0.0, 1.0) * (0.15 + 0.85 * random[:, 6] ** 2)
    root, side = np.nonzero(shows & ((width > 0.0) & (closeness > 0.0))[:, None])
    return Hairs(*(a[root] for a in (triangle, weights, random, width, long)), side)


def shown_width(pixel: np.ndarray, diameter: float, number: np.ndarray) -> np.ndarray:
    """How much wider hairs are drawn where `pixel` metres are a pixel, so that the mean of all is 1; `number`: from 0 to 1,
    of each. Hairs much thinner than a pixel are fewer and wider instead (Cook et al. 2007), and none appears at once."""
    share = np.minimum(1.0, FINEST * diameter / pixel)
    share *= min(1.0, MOST / max(share.sum(), 1.0))
    share = np.minimum(share, 1.0)
    # Number n is there from share = n / (1 + FADE) on, and whole from share = n / 1 on: a ramp whose mean is known.
    ends = np.minimum(share * (1.0 + FADE), 1.0)
    here = np.clip((share * (1.0 + FADE) - number) / (FADE * share), 0.0, 1.0)
    whole = share
    ramp = ends - whole
    lowest = np.clip((share * (1.0 + FADE) - ends) / (FADE * share), 0.0, 1.0)
    return here / (whole + ramp * 0.5 * (1.0 + lowest))


@dataclass(frozen=True)
class _Near:
    """Points that hairs must be near, within `reach`; `side` [N]: the side of the cloth that is seen there, None: both."""

    points: np.ndarray
    reach: float
    side: np.ndarray | None

    def __post_init__(self):
        object.__setattr__(self, "tree", cKDTree(self.points))


def _closeness(near: list[_Near], place: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """How near places [N, 3] are, 1 to 0, and which side's hairs [N, 2] may be seen."""
    best, shows = np.zeros(len(place)), np.zeros((len(place), 2), bool)
    for one in near:
        distance, number = one.tree.query(place, distance_upper_bound=one.reach)
        within = distance < one.reach
        best = np.maximum(best, np.where(within, 1.0 - distance / one.reach, 0.0))
        for side in (0, 1):
            shows[:, side] |= within if one.side is None else within & (np.append(one.side, -1)[number] == side)
    return best, shows


class _View:
    """A mesh before a camera: which triangles may be in the picture, and how large a pixel is at its vertices."""

    def __init__(self, mesh: Mesh, camera: Camera, size: tuple[int, int], margin: float):
        self.camera, self.size = camera, size
        p = mesh.positions.astype(float)
        right, up, forward = camera.axes
        toward = p - camera.eye
        depth = toward @ forward
        self.pixel = self._pixels(depth)
        room = margin + self.pixel
        across, above = toward @ right - camera.shear[0] * depth, toward @ up - camera.shear[1] * depth
        x, y = (half * self.pixel + room for half in (0.5 * size[0], 0.5 * size[1]))
        corners = mesh.triangles
        apart = [a[corners].all(1) for a in (across > x, across < -x, above > y, above < -y, depth <= 0.0)]
        self.inside = ~np.any(apart, axis=0)
        point, w = camera.viewpoint[:3], camera.viewpoint[3]
        away = point - w * p
        self.facing = (mesh.normals * away).sum(1) / np.maximum(np.linalg.norm(away, axis=1), 1e-30)

    def _pixels(self, depth: np.ndarray) -> np.ndarray:
        """Metres across a pixel that faces the camera."""
        if self.camera.ortho is not None:
            return np.full(np.shape(depth), self.camera.ortho / self.size[1])
        return 2.0 * np.tan(np.radians(self.camera.fov_deg) / 2) / self.size[1] * np.maximum(depth, 1e-6)

    def pixel_at(self, place: np.ndarray) -> np.ndarray:
        return self._pixels((place - self.camera.eye) @ self.camera.axes[2])

    def shown(self, place: np.ndarray, margin: float) -> np.ndarray:
        """Which places [N, 3] are in the picture, or `margin` metres beside it."""
        right, up, forward = self.camera.axes
        toward = place - self.camera.eye
        depth = toward @ forward
        pixel = self._pixels(depth)
        across, above = toward @ right - self.camera.shear[0] * depth, toward @ up - self.camera.shear[1] * depth
        return (depth > 0.0) & (abs(across) < 0.5 * self.size[0] * pixel + margin) & (
            abs(above) < 0.5 * self.size[1] * pixel + margin
        )  # fmt: skip


def _outlines(mesh: Mesh, view: _View, inside: np.ndarray, length: float) -> tuple[np.ndarray, np.ndarray]:
    """Points [N, 3] where the surface turns away from the camera, and which side of it is seen there [N]."""
    corners = mesh.triangles[inside]
    f = view.facing[corners]
    crossed = corners[(f.min(1) < 0.0) & (f.max(1) > 0.0)]
    if not len(crossed):
        return np.zeros((0, 3)), np.zeros(0, int)
    f, p = view.facing[crossed], mesh.positions[crossed].astype(float)
    ends = []
    for i, j in ((0, 1), (1, 2), (2, 0)):
        cuts = (f[:, i] < 0.0) != (f[:, j] < 0.0)
        t = np.where(cuts, f[:, i] / np.where(cuts, f[:, i] - f[:, j], 1.0), np.nan)[:, None]
        ends.append(p[:, i] + t * (p[:, j] - p[:, i]))
    ends = np.stack(ends, 1)
    ends = ends[np.isfinite(ends).all(2)].reshape(-1, 2, 3)
    points, which = _along(ends, length, view, REACH * length)
    return points, _seen_side(f, p, view)[which]


def _seen_side(f: np.ndarray, p: np.ndarray, view: _View) -> np.ndarray:
    """Which side is seen where triangles [N, 3, 3] turn away: the one that the part nearer to the camera turns to it."""
    a, b = p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]
    n = np.cross(a, b)
    # The gradient of f in the plane of the triangle, times the square of n.
    slope = (f[:, 1] - f[:, 0])[:, None] * np.cross(b, n) + (f[:, 2] - f[:, 0])[:, None] * np.cross(n, a)
    away = view.camera.viewpoint[:3] - view.camera.viewpoint[3] * p.mean(1)
    return np.where((slope * away).sum(1) > 0.0, 0, 1)


def _rims(edges: np.ndarray, view: _View, far: float, length: float) -> np.ndarray:
    """Points [N, 3] where the cloth ends, on edges [N, 2, 3]."""
    near = view.pixel_at(edges).min(1, initial=np.inf) < far
    return _along(edges[near].astype(float), 0.5 * length, view, RIM_REACH * length)[0]


def rim_edges(mesh: Mesh) -> np.ndarray:
    """Edges [N, 2] of one triangle alone; vertices at one place count as one."""
    _, same = np.unique(mesh.positions, axis=0, return_inverse=True)
    edges = mesh.triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    _, first, count = np.unique(np.sort(same.reshape(-1)[edges], 1), axis=0, return_index=True, return_counts=True)
    return edges[first[count == 1]]


def _along(ends: np.ndarray, step: float, view: _View, margin: float) -> tuple[np.ndarray, np.ndarray]:
    """Points on segments [N, 2, 3], `step` apart or less, of those in view, and of which segment each is."""
    if not len(ends):
        return np.zeros((0, 3)), np.zeros(0, int)
    long = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    count = np.maximum(np.ceil(long / step), 1).astype(int)
    while count.sum() > 8 * MOST_POINTS:
        count = np.maximum(count // 2, 1)
        if (count == 1).all():
            break
    which = np.repeat(np.arange(len(ends)), count)
    t = ((_within(count) + 0.5) / count[which])[:, None]
    points = ends[which, 0] + t * (ends[which, 1] - ends[which, 0])
    here = np.flatnonzero(view.shown(points, margin))
    here = here[:: max(len(here) // MOST_POINTS, 1)]
    return points[here], which[here]


def _within(count: np.ndarray) -> np.ndarray:
    """0, 1, .. count - 1 for each of some counts, one after the other."""
    return np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count)


def _pieces(mesh: Mesh, inside: np.ndarray, points: list[_Near]) -> tuple[np.ndarray, np.ndarray]:
    """Parts of triangles near points: their triangles [N], and their corners' weights [N, 3, 2]."""
    number, weights = inside, np.tile(np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]), (len(inside), 1, 1))
    done: list[tuple[np.ndarray, np.ndarray]] = []
    for _ in range(48):
        p = mesh.positions[mesh.triangles[number]].astype(float)
        corners = _at(np.repeat(p, 3, axis=0), weights.reshape(-1, 2)).reshape(-1, 3, 3)
        middle = corners.mean(1)
        radius = np.linalg.norm(corners - middle[:, None], axis=2).max(1)
        near, small = np.zeros(len(number), bool), np.zeros(len(number), bool)
        for one in points:
            close = one.tree.query(middle)[0] < one.reach + radius
            near |= close
            small |= close & (radius <= one.reach)
        done.append((number[near & small], weights[near & small]))
        number, weights = number[near & ~small], weights[near & ~small]
        if not len(number):
            break
        longest = np.linalg.norm(corners - np.roll(corners, -1, 1), axis=2).argmax(1)[near & ~small]
        number, weights = np.repeat(number, 2), _halves(weights, longest)
    return np.concatenate([n for n, _ in done]), np.concatenate([w for _, w in done])


def _halves(weights: np.ndarray, side: np.ndarray) -> np.ndarray:
    """The two parts [2 N, 3, 2] of triangles [N, 3, 2], cut through a side [N]: that from corner `side` to the next."""
    order = (side[:, None] + np.arange(3)) % 3
    a, b, c = np.moveaxis(np.take_along_axis(weights, order[..., None], 1), 1, 0)
    middle = (a + b) / 2
    return np.stack([np.stack([a, middle, c], 1), np.stack([middle, b, c], 1)], 1).reshape(-1, 3, 2)


def _at(corners: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Values at weights [N, 2] of triangles whose corners have [N, 3, n]."""
    a = corners[:, 0]
    return a + weights[:, :1] * (corners[:, 1] - a) + weights[:, 1:] * (corners[:, 2] - a)


def _roots(
    mesh: Mesh, metres: float, pieces: tuple, density: float, most: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The hairs whose roots lie in pieces: triangles [N], weights [N, 2], random numbers [N, 8], of these the last at most
    `most`."""
    assert mesh.uv is not None
    number, weights = pieces
    uv = metres * np.sqrt(density) * mesh.uv[mesh.triangles[number]].astype(float)  # in cells
    corners = _at(np.repeat(uv, 3, axis=0), weights.reshape(-1, 2)).reshape(-1, 3, 2)
    cells = (corners.max(1) - corners.min(1) + 1.0).prod(1)  # about
    keep = (cells < CELLS_AT_A_TIME) & (np.abs(corners).max((1, 2)) < 2.0**52)  # others are UVs gone wild
    number, weights, corners, cells = (a[keep] for a in (number, weights, corners, cells))
    corners *= np.sqrt(min(1.0, MOST_CELLS / max(float(cells.sum()), 1.0)))
    found = [
        _in_cells(number[some], weights[some], corners[some], most)
        for some in np.split(np.arange(len(number)), np.flatnonzero(np.diff(np.cumsum(cells) // CELLS_AT_A_TIME)) + 1)
    ]
    triangle, own, random = (np.concatenate(parts) for parts in zip(*found, strict=True))
    return triangle, own, random


def _in_cells(
    number: np.ndarray, weights: np.ndarray, corners: np.ndarray, most: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """As `_roots`, of some pieces; `corners` [N, 3, 2] in cells."""
    low = np.floor(corners.min(1)).astype(np.int64)
    count = np.floor(corners.max(1)).astype(np.int64) - low + 1
    cells = count.prod(1)
    which = np.repeat(np.arange(len(number)), cells)
    order = _within(cells)
    cell = low[which] + np.stack([order % count[which, 0], order // count[which, 0]], 1)
    bits = _bits(cell)
    few = np.flatnonzero(_random(bits, RANDOM - 1, 1)[:, 0] <= most)
    which, cell = which[few], cell[few]
    random = _random(bits[few], 0, RANDOM + 2)
    place = cell + random[:, RANDOM:]
    a = corners[which, 0]
    b, c = corners[which, 1] - a, corners[which, 2] - a
    area = b[:, 0] * c[:, 1] - b[:, 1] * c[:, 0]
    d = place - a
    area = np.where(area == 0.0, np.inf, area)
    v = (d[:, 0] * c[:, 1] - d[:, 1] * c[:, 0]) / area
    w = (b[:, 0] * d[:, 1] - b[:, 1] * d[:, 0]) / area
    here = (v >= 0.0) & (w >= 0.0) & (v + w < 1.0) & np.isfinite(area)
    which, own = which[here], np.stack([v[here], w[here]], 1)
    return number[which], _at(weights[which], own), random[here, :RANDOM]


def _bits(cell: np.ndarray) -> np.ndarray:
    """64 bits [N] that cells [N, 2] alone say (splitmix64: Steele, Lea and Flood 2014)."""
    with np.errstate(over="ignore"):
        return _mixed(cell[:, 0].astype(np.uint64) * GOLDEN ^ _mixed(cell[:, 1].astype(np.uint64)))


def _random(bits: np.ndarray, first: int, count: int) -> np.ndarray:
    """Numbers `first` and following [N, count] of bits [N], from 0 to 1."""
    with np.errstate(over="ignore"):
        steps = np.arange(first + 1, first + count + 1, dtype=np.uint64) * GOLDEN
        return (_mixed(bits[:, None] + steps) >> np.uint64(40)).astype(float) / 2.0**24


def _mixed(x: np.ndarray) -> np.ndarray:
    x = (x ^ (x >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    x = (x ^ (x >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return x ^ (x >> np.uint64(31))
