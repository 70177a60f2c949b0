"""Form factors of a room with a curtain: what share of its hemisphere each element sees of each patch, of the curtain, and
of the openings through which the sky shines in. They depend on the room's shape alone, and are kept on disk.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import moderngl
import numpy as np

from ..accel.queries import RayQueries
from ..accel.structure import Structure, tracing
from ..accel.triangles import find_pairs
from ..geometry.camera import r2_points
from ..gpu.buffers import Buffer, TextureBuffer
from ..gpu.programs import programs
from ..kept import keep, kept_path, read_kept
from ..twins.random import cosine_direction
from .charts import Charts, make_charts

FORMAT, MOST_FILES = 2, 16  # of the files
# Borders of the cells of the curtain as a sheet, in shares of it: across, across a piece of a pair, and up from its lower edge.
# They are smaller at its rim, where what it sends falls off: cloth beside the window has no lamp and less sky.
ACROSS = np.cumsum([0, 2, 3, 3, 4, 4, 4, 4, 4, 4, 3, 3, 2]) / 40
OF_A_PIECE = np.cumsum([0, 5, 9, 11, 9, 6]) / 40
UP = np.cumsum([0, 5, 6, 7, 7, 6, 5, 3, 1]) / 40
PROXIES = (len(ACROSS) - 1, len(UP) - 1)
CELLS = PROXIES[0] * PROXIES[1]
# By how much the sheet is further into the room a metre below its rail, where factors are known.
LEANS = (0.0, 0.1, 0.25, 0.5)
AZIMUTHS_DEG = (-55.0, 0.0, 55.0)  # of the sheet's normals: folds hang, so that these are all they turn to
OPENING = 0.4  # m, the side of a cell of an opening
LEAKS = 0.02  # the share of leaving rays that says nothing of openings
COUNTS = 1 << 19  # more than the words that count rays
SLICES = 32  # steps of the work
PER_DISPATCH = 1 << 18  # pairs


@dataclass(frozen=True)
class Sheet:
    """The curtain as a flat sheet in the plane z: least and largest x and y at the rail; m.

    flare : by how much each side of a piece of cloth is further out a metre below the rail
    depth : m, how far its folds reach to either side. gap : m, between the two pieces of a pair
    """

    x_0: float
    y_0: float
    x_1: float
    y_1: float
    z: float
    flare: float = 0.0
    depth: float = 0.0
    gap: float = 0.0

    @property
    def panels(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """From where to where its pieces hang; twice the same, if there is one."""
        if not self.gap:
            return (self.x_0, self.x_1), (self.x_0, self.x_1)
        middle = (self.x_0 + self.x_1) / 2
        return (self.x_0, middle - self.gap / 2), (middle + self.gap / 2, self.x_1)

    @cached_property
    def across(self) -> np.ndarray:
        """Borders of cells on the rail, in widths of the sheet."""
        if not self.gap:
            return ACROSS
        piece = (self.panels[0][1] - self.x_0) / (self.x_1 - self.x_0)
        return np.concatenate([piece * OF_A_PIECE, [0.5], 1 - piece * OF_A_PIECE[::-1]])

    @property
    def cloth(self) -> np.ndarray:
        """Which cells are cloth, [proxies]: all but those between the pieces."""
        across = np.ones(PROXIES[0], bool)
        across[len(OF_A_PIECE) - 1 : -(len(OF_A_PIECE) - 1)] = not self.gap
        return np.tile(across, PROXIES[1])

    def nodes(self, lean: float = 0.0) -> np.ndarray:
        """Corners of its cells, [ny + 1, nx + 1, 3], row by row from below."""
        y = self.y_0 + (self.y_1 - self.y_0) * UP
        below = (self.y_1 - y)[:, None]
        top = self.x_0 + (self.x_1 - self.x_0) * self.across
        x = np.tile(top, (len(y), 1))
        for low, high in self.panels[: 1 + bool(self.gap)]:
            here = (top > low - 1e-9) & (top < high + 1e-9)
            middle, reach = (low + high) / 2, (high - low) / 2
            x[:, here] = middle + (top[here] - middle) * (1 + self.flare * below / reach)
        return np.stack(np.broadcast_arrays(x, y[:, None], self.z + lean * below), -1)

    @property
    def rims(self) -> np.ndarray:
        """Its four sides, [4, 2, 3]."""
        corners = self.nodes()[[0, 0, -1, -1], [0, -1, -1, 0]]
        return np.stack([corners, np.roll(corners, -1, 0)], 1)

    @property
    def rectangle(self) -> tuple[float, float, float, float]:
        """As passes take it."""
        return self.x_0, self.y_0, self.x_1, self.y_1

    @property
    def piece(self) -> tuple[float, float, float, float]:
        """As `rectangle`, of the first piece."""
        return self.x_0, self.y_0, self.panels[0][1], self.y_1

    def cells(self, lean: float = 0.0) -> np.ndarray:
        """Corners [2 x proxies, 4, 3] of its cells, row by row from below: those of the front (+z), then of the back."""
        n = self.nodes(lean)
        front = np.stack([n[:-1, :-1], n[:-1, 1:], n[1:, 1:], n[1:, :-1]], 2).reshape(-1, 4, 3)
        return np.concatenate([front, front[:, ::-1]])

    def receivers(self) -> tuple[np.ndarray, np.ndarray]:
        """Positions and normals [6 x proxies, 3]: of the front the azimuths of each cell, then of the back."""
        middle = self.cells()[:CELLS].mean(1)
        a = np.radians(AZIMUTHS_DEG)
        normals = np.stack([np.sin(a), np.zeros(3), np.cos(a)], 1)
        off = np.array([0.0, 0.0, 1e-3])
        front, back = np.repeat(middle + off, 3, 0), np.repeat(middle - off, 3, 0)
        tile = np.tile(normals, (len(middle), 1))
        return np.concatenate([front, back]), np.concatenate([tile, tile * [1.0, 1.0, -1.0]])


@dataclass(frozen=True)
class FormFactors:
    """What R receivers (the room's N elements, then the curtain's) see of S senders (P patches, front and back of the
    curtain's cells, cells of openings).

    charts : of the room. openings : [W, 4, 3] corners, seen from the room
    factors : [S, R] float32, cloth hides nothing
    leaning : [3, 2 x proxies, N] float32, of its cells where it leans by LEANS[1:]
    crossings : [P + W, N] uint32, as passes/curtain/factors.comp counts which of it crosses the curtain
    """

    charts: Charts
    sheet: Sheet
    openings: np.ndarray
    factors: np.ndarray
    leaning: np.ndarray
    crossings: np.ndarray

    @property
    def light_senders(self) -> int:
        """How many senders there are but for the openings: patches and the curtain's cells."""
        return len(self.factors) - len(self.openings)

    @property
    def receivers(self) -> tuple[np.ndarray, np.ndarray]:
        """Positions and normals, [R, 3]."""
        x, n = self.sheet.receivers()
        return np.concatenate([self.charts.positions, x]), np.concatenate([self.charts.normals, n])

    def crossing(self, lean: int = 0) -> np.ndarray:
        """The share of the factors of patches and openings for the room that crosses the curtain at LEANS[lean], [P + W, N]."""
        seen = np.maximum(self.crossings & 7, 1)
        return (self.crossings >> (3 + 3 * lean) & 7).astype(np.float32) / seen

    @property
    def columns(self) -> np.ndarray:
        """Of the curtain, where these cross: [P + W, N]."""
        return self.crossings >> 15

    def openness(self) -> np.ndarray:
        """The share of its hemisphere that each element sees of the room and its openings, [N]."""
        shares = self.factors[:, : len(self.charts.positions)]
        P, W = len(self.charts.patches), len(self.openings)
        return shares[:P].sum(0) + shares[len(shares) - W :].sum(0)


def facing_the_room(
    positions: np.ndarray, structure: Structure, ctx: moderngl.Context, material: np.ndarray | int = 0
) -> np.ndarray:
    """Triangles [T, 3, 3] of materials [T], turned over where their front sees nothing of the room but their back does."""
    u = r2_points(32)
    z = cosine_direction(u)
    normal = np.cross(positions[:, 1] - positions[:, 0], positions[:, 2] - positions[:, 0]).astype(float)
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-30)
    middle, offset = positions.mean(1).astype(float), 1e-4 * float(np.ptp(positions.reshape(-1, 3), axis=0).max())
    queries = RayQueries(ctx)
    seen = []
    for n in (normal, -normal):
        d = _about(n, z)
        o = np.broadcast_to((middle + offset * n)[:, None], d.shape)
        way = queries.closest_hit(structure, o.reshape(-1, 3), d.reshape(-1, 3)).t.reshape(len(n), -1)
        seen.append((np.isfinite(way).mean(1), np.median(np.where(np.isfinite(way), way, 0.0), 1)))
    queries.release()
    # What is near is the inside of a thing, such as of a window's frame, whose outer face sees the sky alone.
    over = (seen[0][0] < 0.1) & (seen[1][0] > 0.5) & (seen[1][1] > 0.1 * 1e4 * offset)
    joined = np.flatnonzero(find_pairs(positions, np.broadcast_to(material, len(positions)))[1])
    over[joined + 1] = over[joined]
    return np.where(over[:, None, None], positions[:, ::-1], positions)


def find_openings(
    charts: Charts, low: np.ndarray, high: np.ndarray, structure: Structure, ctx: moderngl.Context
) -> np.ndarray:
    """Cells [W, 4, 3] on the room's bounding box that cover where rays of its elements leave it."""
    d = _about(charts.normals, cosine_direction(r2_points(8)))
    o = np.broadcast_to((charts.positions + 1e-4 * (high - low).max() * charts.normals)[:, None], d.shape).reshape(
        -1, 3
    )
    d = d.reshape(-1, 3)
    queries = RayQueries(ctx)
    free = ~queries.any_hit(structure, o, d)
    queries.release()
    # Elements on the outside see nearly nothing else; they say nothing of the openings, unless there is no inside.
    outside = free.reshape(len(charts.positions), -1).mean(1) > 0.9
    free &= np.repeat(~outside | outside.all(), len(free) // len(outside))
    o, d = o[free], d[free]
    with np.errstate(divide="ignore", invalid="ignore"):
        ways = np.where(d > 0, (high - o) / d, np.where(d < 0, (low - o) / d, np.inf))
    axis = ways.argmin(1)
    points = o + np.maximum(ways.min(1), 0)[:, None] * d
    cells = []
    for a in range(3):
        for side in (0, 1):
            left = points[(axis == a) & ((d[:, a] > 0) == bool(side))]
            # Surfaces that touch leak a few rays.
            if len(left) > LEAKS * len(points):
                cells.append(_cells(left, a, side, low, high))
    return np.concatenate(cells) if cells else np.zeros((0, 4, 3))


def _cells(points: np.ndarray, axis: int, side: int, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Cells over the rectangle that bounds points on a face of a box, seen from within."""
    u, v = (axis + 1) % 3, (axis + 2) % 3
    edges = []
    for k in (u, v):
        # The last rays that pass leave a gap to the opening's edge.
        a, b = np.quantile(points[:, k], [LEAKS / 4, 1 - LEAKS / 4]) + np.array([-0.02, 0.02])
        a, b = max(low[k], a), min(high[k], b)
        edges.append(np.linspace(a, b, min(12, max(1, round((b - a) / OPENING))) + 1))
    a_0, b_0 = (e.ravel() for e in np.meshgrid(edges[0][:-1], edges[1][:-1], indexing="ij"))
    a_1, b_1 = (e.ravel() for e in np.meshgrid(edges[0][1:], edges[1][1:], indexing="ij"))
    out = np.empty((len(a_0), 4, 3))
    out[..., axis] = (low, high)[side][axis]
    out[..., u], out[..., v] = np.stack([a_0, a_1, a_1, a_0], 1), np.stack([b_0, b_0, b_1, b_1], 1)
    return out[:, ::-1] if side else out


def _about(normals: np.ndarray, z: np.ndarray) -> np.ndarray:
    """Directions z [K, 3] about +z turned about each normal, [N, K, 3]."""
    other = np.where(np.abs(normals[:, :1]) > 0.7, [0.0, 1.0, 0.0], [1.0, 0.0, 0.0])
    x = np.cross(other, normals)
    x /= np.maximum(np.linalg.norm(x, axis=1, keepdims=True), 1e-30)
    y = np.cross(normals, x)
    return z[None, :, :1] * x[:, None] + z[None, :, 1:2] * y[:, None] + z[None, :, 2:] * normals[:, None]


def factor_steps(
    ctx: moderngl.Context,
    positions: np.ndarray,
    structure: Structure,
    sheet: Sheet,
    cell: float | None = None,
    material: np.ndarray | int = 0,
) -> Iterator[float | FormFactors]:
    """Find the form factors of a room [T, 3, 3], from the cache or anew: yields the share that is done, at last them.

    structure : of the room's triangles. cell, material : as for `make_charts`. Raises InputError as that does.
    """
    material = np.broadcast_to(material, len(positions))
    positions = facing_the_room(positions, structure, ctx, material)
    charts = make_charts(positions, cell, material, sheet.rims)
    low, high = positions.reshape(-1, 3).min(0).astype(float), positions.reshape(-1, 3).max(0).astype(float)
    openings = find_openings(charts, low, high, structure, ctx)
    about = FORMAT, sheet, cell, LEANS, AZIMUTHS_DEG
    path = kept_path("factors", about, sheet.nodes(), positions, charts.patches, openings)
    P, N, W = len(charts.patches), len(charts.positions), len(openings)
    shapes = (P + 2 * CELLS + W, N + 6 * CELLS), (len(LEANS) - 1, 2 * CELLS, N), (P + W, N)
    sizes = [int(np.prod(shape)) for shape in shapes]
    found = read_kept(path, (sum(sizes),), 1.001)
    if found is None:
        offset = 1e-4 * float((high - low).max())
        for found in _compute(ctx, charts, openings, structure, sheet, offset):
            if isinstance(found, float):
                yield found
        keep(path, found, MOST_FILES)
    factors, leaning, crossings = (
        part.reshape(shape) for part, shape in zip(np.split(found, np.cumsum(sizes)[:-1]), shapes, strict=True)
    )
    yield FormFactors(charts, sheet, openings, factors, leaning, (crossings * COUNTS).astype(np.uint32))


def _compute(
    ctx: moderngl.Context, charts: Charts, openings: np.ndarray, structure: Structure, sheet: Sheet, offset: float
) -> Iterator[float | np.ndarray]:
    """The share that is done, at last all that is kept, as one array of float32."""
    x, n = sheet.receivers()
    N, P = len(charts.positions), len(charts.patches)
    receivers = np.zeros((N + len(x), 2, 4), np.float32)
    receivers[:, 0, :3], receivers[:, 1, :3] = (
        np.concatenate([charts.positions, x]),
        np.concatenate([charts.normals, n]),
    )
    receivers[N:, 0, 3] = 1.0
    # The room's elements alone see the sheet lean.
    jobs = [(len(receivers), P, [charts.patches, sheet.cells(), openings])] + [
        (N, 0, [sheet.cells(l)]) for l in LEANS[1:]
    ]
    whole = sum(count * sum(map(len, senders)) for count, _, senders in jobs)
    program = programs(ctx).compute("passes/curtain/factors.comp", {"COLUMNS": PROXIES[0]}, tracing(structure))
    given, out, done = TextureBuffer(ctx, receivers), [], 0
    names = {
        "panels": sum(sheet.panels, ()), "height": (sheet.y_0, sheet.y_1), "sheet_z": sheet.z, "flare": sheet.flare,
        "depth": sheet.depth, "leans": LEANS, "columns": list(sheet.x_0 + (sheet.x_1 - sheet.x_0) * sheet.across),
    }  # fmt: skip
    crossings = np.zeros(0)
    try:
        for lean, (R, before, polygons) in enumerate(jobs):
            corners = np.concatenate(polygons)
            S = len(corners)
            senders = np.zeros((S, 4, 4), np.float32)
            senders[..., :3] = corners
            senders[before : before + 2 * CELLS, 0, 3] = 1.0
            taken, F, counted = TextureBuffer(ctx, senders), Buffer(ctx, 4 * R * S), Buffer(ctx, 4 * R * S)
            try:
                step = max(1, PER_DISPATCH // R)
                for first in range(0, S, step):
                    count = min(step, S - first)
                    program.run(
                        R * count, structure.inputs(), names, receivers=given, senders=taken, Factors=F, Crossings=counted,
                        receiver_count=R, first=first, sender_count=count, offset=offset, lean_of_sheet=lean,
                    )  # fmt: skip
                    ctx.finish()
                    before_it, done = done, done + R * count
                    for k in range(SLICES * before_it // whole, SLICES * done // whole):
                        yield k / SLICES
                factors = np.frombuffer(F.read(4 * R * S), np.float32).reshape(S, R).copy()
                factors[before : before + 2 * CELLS][~np.tile(sheet.cloth, 2)] = 0.0
                out.append(factors.ravel())
                if not lean:
                    words = np.frombuffer(counted.read(4 * R * S), np.uint32).reshape(S, R)
                    crossings = np.delete(words, slice(P, P + 2 * CELLS), 0)[:, :N].ravel() / np.float32(COUNTS)
            finally:
                for buffer in (taken, F, counted):
                    buffer.release()
        yield np.concatenate([*out, crossings]).astype(np.float32)
    finally:
        given.release()
