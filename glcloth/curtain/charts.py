"""A room's triangles as charts: grids of elements that receive light, groups of these (patches) that send it, and the
texels from which a point of the room reads its light.

Triangles that form a parallelogram with their successor are one chart of nu x nv cells, an element each. A lone triangle
takes the half of its parallelogram, in rows of n, n - 1, ... cells; those on the long side are triangles.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.spatial import cKDTree

from ..accel.triangles import find_pairs, rotated_corners
from ..errors import InputError

CELL = 0.15  # m, the side of an element
PATCH = 3.3  # sides of an element: the side of a patch
RIM_REACH = 0.35  # m: patches as near to a rim of the curtain are narrow across it
RIM_LENGTH = 0.5  # m: along which it is as near
ELEMENTS = 5000.0  # about so many of them in a room, however large
MOST = 32_000_000  # elements times patches: their factors take four bytes each
MOST_PATCHES = 4000  # what each sends to each is solved for: a matrix as large as their square
NO_AREA = 1e-12  # m^2: less than this is rounding
OPEN = 0.35  # the share of its hemisphere that an element must see, or it lies under or within other things


@dataclass(frozen=True)
class Charts:
    """Charts C, elements N, patches P; metres.

    origin, u, v : [C, 3], the parallelogram. cells : [C, 2] int. halves : [C] bool, lone triangles
    chart_of : [T] int, of each triangle of the room
    positions, normals, sides_u, sides_v : [N, 3], middle, unit normal and sides of each element
    area : [N] m^2; patch_of : [N] int; element_chart : [N] int
    patches : [P, 4, 3] corners, counter-clockwise from the front; patch_triangle : [P] int, a triangle that it lies on
    """

    origin: np.ndarray
    u: np.ndarray
    v: np.ndarray
    cells: np.ndarray
    halves: np.ndarray
    chart_of: np.ndarray
    positions: np.ndarray
    normals: np.ndarray
    sides_u: np.ndarray
    sides_v: np.ndarray
    area: np.ndarray
    patch_of: np.ndarray
    element_chart: np.ndarray
    patches: np.ndarray
    patch_triangle: np.ndarray

    @cached_property
    def texel_first(self) -> np.ndarray:
        """The first texel of each chart, [C + 1] int: (nu + 2) x (nv + 2) of them, a rim of one cell round the chart."""
        return np.concatenate([[0], np.cumsum((self.cells + 2).prod(1))])

    def records(self) -> np.ndarray:
        """What a pass reads of each chart, [C, 3, 4] float32: (origin, first texel) and twice (how a place along u or v
        follows from a point, number of cells)."""
        normal = np.cross(self.u, self.v)
        square = (normal**2).sum(1, keepdims=True)
        out = np.zeros((len(self.u), 3, 4), np.float32)
        out[:, 0, :3], out[:, 0, 3] = self.origin, self.texel_first[:-1]
        out[:, 1, :3], out[:, 1, 3] = np.cross(self.v, normal) / square, self.cells[:, 0]
        out[:, 2, :3], out[:, 2, 3] = np.cross(normal, self.u) / square, self.cells[:, 1]
        return out

    def texels(self, openness: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Which elements each texel is the mean of, [X, 4] int, and their weights [X, 4].

        openness : [N], the share of its hemisphere that each element sees

        Elements that lie under other things are filled from the nearest open one. The rim continues a neighbouring chart
        of the same plane, so that no seam shows; where there is none, the chart's own border.
        """
        open_ = openness >= OPEN
        open_ = open_ if open_.any() else np.ones_like(open_)
        place = np.concatenate([self.positions, 0.3 * self.normals], 1)
        fill = np.arange(len(place))
        fill[~open_] = np.flatnonzero(open_)[cKDTree(place[open_]).query(place[~open_])[1]] if (~open_).any() else []
        # Charts of one plane: a normal that differs is further away than any neighbour.
        tree = cKDTree(np.concatenate([self.positions, 50.0 * self.normals], 1))
        source, weight = np.zeros((self.texel_first[-1], 4), int), np.zeros((self.texel_first[-1], 4))
        starts = np.searchsorted(self.element_chart, np.arange(len(self.u)))
        for k, (nu, nv) in enumerate(self.cells):
            i, j = (a.ravel() for a in np.meshgrid(np.arange(-1, nu + 1), np.arange(-1, nv + 1)))
            own = self._own(k, starts[k], i, j)
            rows = slice(self.texel_first[k], self.texel_first[k + 1])
            source[rows], weight[rows] = fill[own][:, None], [1.0, 0.0, 0.0, 0.0]
            outside = np.flatnonzero(self._outside(k, i, j))
            s, t = (i[outside] + 0.5) / nu, (j[outside] + 0.5) / nv
            points = self.origin[k] + s[:, None] * self.u[k] + t[:, None] * self.v[k]
            normals = np.broadcast_to(50.0 * self.normals[starts[k]], points.shape)
            near = min(4, len(place))
            distance, found = tree.query(np.concatenate([points, normals], 1), k=near)
            distance, found = distance.reshape(-1, near), found.reshape(-1, near)
            side = max(np.linalg.norm(self.u[k]) / nu, np.linalg.norm(self.v[k]) / nv)
            other = (self.element_chart[found[:, 0]] != k) & (distance[:, 0] < 0.75 * side)
            share = 1.0 / (distance + 1e-4 * side) ** 2
            share /= share.sum(1, keepdims=True)
            at = self.texel_first[k] + outside[other]
            source[at, :near], weight[at, :near] = fill[found[other]], share[other]
        return source, weight

    def _outside(self, k: int, i: np.ndarray, j: np.ndarray) -> np.ndarray:
        nu, nv = self.cells[k]
        beyond = (i < 0) | (j < 0) | (i >= nu) | (j >= nv)
        return beyond | (i + j >= nu) if self.halves[k] else beyond

    def _own(self, k: int, start: int, i: np.ndarray, j: np.ndarray) -> np.ndarray:
        """The chart's own element nearest to cells (i, j)."""
        nu, nv = self.cells[k]
        i, j = np.clip(i, 0, nu - 1), np.clip(j, 0, nv - 1)
        if not self.halves[k]:
            return start + j * nu + i
        over = np.maximum(i + j - (nu - 1), 0)
        i = np.maximum(i - (over + 1) // 2, 0)
        j = np.minimum(j, nu - 1 - i)
        return start + j * nu - j * (j - 1) // 2 + i


def make_charts(
    positions: np.ndarray, cell: float | None = None, material: np.ndarray | int = 0, rims: np.ndarray | None = None
) -> Charts:
    """The charts of triangles [T, 3, 3], their fronts in front.

    cell : m, the side of an element; default: 0.15, or more in large rooms and rooms of very many parts
    material : [T] int, or one for all: a chart has one
    rims : [E, 2, 3] the ends of a curtain's rims: light falls off across them, so patches near them are narrow

    Raises InputError for more triangles than can be lit, and where none has an area.
    """
    positions = np.asarray(positions, float)
    shapes, chart_of = _parallelograms(positions, np.broadcast_to(material, len(positions)))
    if not shapes:
        raise InputError("room: no triangle has an area; mend it, or take --gi off")
    area = sum(np.linalg.norm(np.cross(u, v)) * (0.5 if half else 1.0) for _, u, v, half, _ in shapes)
    side = cell or max(CELL, (area / ELEMENTS) ** 0.5)
    while True:
        charts = _divided(shapes, chart_of, side, np.zeros((0, 2, 3)) if rims is None else rims)
        if len(charts.positions) * len(charts.patches) <= MOST and len(charts.patches) <= MOST_PATCHES:
            return charts
        if len(shapes) > most_parts():
            raise InputError(
                f"room: {len(positions)} triangles in {len(shapes)} parts, too many for --gi radiosity (at most "
                f"{most_parts()}); simplify it, or take --gi photons or off"
            )
        side *= 1.25


def most_parts() -> int:
    """How many parts of a room can be lit: each is one element and one patch at least."""
    return min(int(MOST**0.5), MOST_PATCHES)


def parts_of(positions: np.ndarray, material: np.ndarray | int = 0) -> int:
    """How many parts triangles [T, 3, 3] of materials [T] make; their number where that is no more than can be lit."""
    if len(positions) <= most_parts():
        return len(positions)
    return len(_parallelograms(np.asarray(positions, float), np.broadcast_to(material, len(positions)))[0])


def _parallelograms(positions: np.ndarray, material: np.ndarray) -> tuple[list, np.ndarray]:
    """(origin, u, v, half, first triangle) of each chart, and the chart of each triangle."""
    turn, joined = find_pairs(positions.astype(np.float32), material)
    corners = rotated_corners(positions, turn)
    shapes, chart_of, t = [], np.zeros(len(positions), int), 0
    while t < len(positions):
        a, c, b = corners[t]
        pair = bool(joined[t])
        if pair:
            d = corners[t + 1, 2]
            pair = bool(np.abs(a + d - b - c).max() < 1e-4 * np.abs(d - a).max())
        # What has no area receives nothing, and no ray meets it.
        if np.linalg.norm(np.cross(c - a, b - a)) > NO_AREA:
            chart_of[t : t + 1 + pair] = len(shapes)
            shapes.append((a, c - a, b - a, not pair, t))
        t += 1 + pair
    return shapes, chart_of


def _divided(shapes: list, chart_of: np.ndarray, side: float, rims: np.ndarray) -> Charts:
    """Cut each chart into elements and patches."""
    parts = [
        _half(*(float(np.linalg.norm(w)) for w in (u, v, v - u)), side) if half else _whole(a, u, v, side, rims)
        for a, u, v, half, _ in shapes
    ]
    columns: dict[str, list] = {name: [] for name in ("X", "N", "U", "V", "area", "patch", "chart")}
    patches, patch_triangle = [], []
    for k, ((a, u, v, _, triangle), (cells, middles, share, patch, corners)) in enumerate(
        zip(shapes, parts, strict=True)
    ):
        normal = np.cross(u, v)
        count = len(middles)
        columns["X"].append(a + middles[:, :1] * u + middles[:, 1:] * v)
        for name, value in (("U", u / cells[0]), ("V", v / cells[1])):
            columns[name].append(np.sqrt(share)[:, None] * value)
        columns["N"].append(np.broadcast_to(normal / np.linalg.norm(normal), (count, 3)))
        columns["area"].append(np.linalg.norm(normal) / (cells[0] * cells[1]) * share)
        columns["patch"].append(patch + len(patches))
        columns["chart"].append(np.full(count, k))
        patches += list(a + corners[..., :1] * u + corners[..., 1:] * v)
        patch_triangle += [triangle] * len(corners)
    X, N, U, V, area, patch, chart = (np.concatenate(values) for values in columns.values())
    return Charts(
        np.array([s[0] for s in shapes]), np.array([s[1] for s in shapes]), np.array([s[2] for s in shapes]),
        np.array([p[0] for p in parts]), np.array([s[3] for s in shapes]), chart_of, X, N, U, V, area, patch, chart,
        np.array(patches), np.array(patch_triangle),
    )  # fmt: skip


def _whole(a: np.ndarray, u: np.ndarray, v: np.ndarray, side: float, rims: np.ndarray) -> tuple:
    """Cells (nu, nv); in units of u and v the elements' middles [N, 2], their share of a cell [N], their patches [N], and the
    corners of patches [P, 4, 2]; of a parallelogram."""
    (nu, x), (nv, y) = (_cut(float(np.linalg.norm(w)), side, _near(a, w, other, rims)) for w, other in ((u, v), (v, u)))
    j, i = (a.ravel() for a in np.meshgrid(np.arange(nv), np.arange(nu), indexing="ij"))
    patch = (np.searchsorted(y, j, "right") - 1) * (len(x) - 1) + np.searchsorted(x, i, "right") - 1
    x, y = x / nu, y / nv
    low_y, low_x = (a.ravel() for a in np.meshgrid(y[:-1], x[:-1], indexing="ij"))
    high_y, high_x = (a.ravel() for a in np.meshgrid(y[1:], x[1:], indexing="ij"))
    corners = np.stack([low_x, low_y, high_x, low_y, high_x, high_y, low_x, high_y], 1).reshape(-1, 4, 2)
    middles = np.stack([(i + 0.5) / nu, (j + 0.5) / nv], 1)
    return (nu, nv), middles, np.ones(len(i)), patch, corners


def _cut(length: float, side: float, near: list[tuple[float, float]]) -> tuple[int, np.ndarray]:
    """How many elements lie along a length, and where patches of them begin and end. Within the intervals `near` a patch is one
    element long; where these are most of the length, elements are half as long, two to a patch."""
    n = max(1, round(length / side))
    N = min(n, max(1, round(length / (PATCH * side))))
    here = np.arange(n + 1) * length / n
    fine = np.zeros(n + 1, bool)
    for low, high in near:
        fine |= (here > low) & (here < high)
    # Borders of patches are borders of elements.
    borders = np.unique(np.concatenate([-(-np.arange(N + 1) * n // N), np.flatnonzero(fine)]))
    return (2 * n, 2 * borders) if n > 1 and fine.sum() > 0.5 * n else (n, borders)


def _near(a: np.ndarray, along: np.ndarray, across: np.ndarray, rims: np.ndarray) -> list[tuple[float, float]]:
    """Intervals along a side of a parallelogram in which rims run that lie close to it and go the other way."""
    out, length = [], float(np.linalg.norm(along))
    square = np.stack([along, across])
    for p, q in rims:
        way = float(np.linalg.norm(q - p))
        if abs(float((q - p) @ along)) > 0.3 * way * length:
            continue
        rim = p + np.linspace(0, 1, 33)[:, None] * (q - p)
        place = np.clip(np.linalg.lstsq(square.T, (rim - a).T, rcond=None)[0].T, 0, 1)
        close = np.linalg.norm(a + place @ square - rim, axis=1) < RIM_REACH
        if close.mean() * way > RIM_LENGTH:
            at = (rim[close] - a) @ along / length
            out.append((float(at.min()) - RIM_REACH, float(at.max()) + RIM_REACH))
    return out


def _half(across: float, up: float, slant: float, side: float) -> tuple:
    """As `_whole`, of a triangle."""
    longest = max(across, up, slant)
    P = max(1, round(longest / (PATCH * side)))
    per = max(1, -(-round(longest / side) // P))
    n = P * per
    j, i = np.array([(j, i) for j in range(n) for i in range(n - j)]).T
    rim = i + j == n - 1
    middles = np.stack([i, j], 1) + np.where(rim, 1 / 3, 0.5)[:, None]
    where = {ji: k for k, ji in enumerate((j, i) for j in range(P) for i in range(P - j))}
    patch = np.array([where[ji] for ji in zip((j // per).tolist(), (i // per).tolist(), strict=True)])
    corners = []
    for y, x in where:
        square = [(x, y), (x + 1, y), (x + 1, y + 1), (x, y + 1)]
        corners.append(square if x + y < P - 1 else [square[0], square[1], square[3], square[3]])
    return (n, n), middles / n, np.where(rim, 0.5, 1.0), patch, np.array(corners, float) / P
