"""Form factors of a room with a curtain: what share of its hemisphere each element sees of each patch, of the curtain, and
of the openings through which the sky shines in. They depend on the room's shape alone, and are kept on disk.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import pairwise

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

FORMAT, MOST_FILES = 1, 16  # of the files
# The curtain as a sheet of cells: their borders across, and up from its lower edge. They are smaller at its rim, where what it sends
# falls off: cloth beside the window, above it and below has no lamp and less sky.
ACROSS = np.cumsum([0, 2, 3, 3, 4, 4, 4, 4, 4, 4, 3, 3, 2]) / 40
UP = np.cumsum([0, 5, 6, 7, 7, 6, 5, 3, 1]) / 40
PROXIES = (len(ACROSS) - 1, len(UP) - 1)
AZIMUTHS_DEG = (-55.0, 0.0, 55.0)  # of the sheet's normals: folds hang, so that these are all they turn to
OPENING = 0.4  # m, the side of a cell of an opening
LEAKS = 0.02  # the share of leaving rays that says nothing of openings
SLICES = 32  # steps of the work
PER_DISPATCH = 1 << 18  # pairs


@dataclass(frozen=True)
class Sheet:
    """The curtain as a flat sheet in the plane z: least and largest x and y; m."""

    x_0: float
    y_0: float
    x_1: float
    y_1: float
    z: float
    bent: np.ndarray | None = field(default=None, compare=False, repr=False)

    @property
    def nodes(self) -> np.ndarray:
        """Corners of its cells, [ny + 1, nx + 1, 3], row by row from below."""
        if self.bent is not None:
            return self.bent
        x, y = self.x_0 + (self.x_1 - self.x_0) * ACROSS, self.y_0 + (self.y_1 - self.y_0) * UP
        return np.stack(np.broadcast_arrays(x[None], y[:, None], self.z), -1)

    @property
    def rectangle(self) -> tuple[float, float, float, float]:
        """As passes take it."""
        return self.x_0, self.y_0, self.x_1, self.y_1

    def cells(self) -> np.ndarray:
        """Corners [2 x proxies, 4, 3] of its cells, row by row from below: those of the front (+z), then of the back."""
        n = self.nodes
        front = np.stack([n[:-1, :-1], n[:-1, 1:], n[1:, 1:], n[1:, :-1]], 2).reshape(-1, 4, 3)
        return np.concatenate([front, front[:, ::-1]])

    def receivers(self) -> tuple[np.ndarray, np.ndarray]:
        """Positions and normals [6 x proxies, 3]: of the front the azimuths of each cell, then of the back."""
        middle = self.cells()[: PROXIES[0] * PROXIES[1]].mean(1)
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
    factors : [S, R] float32; crossing: of these, what crosses the curtain, which attenuates it
    """

    charts: Charts
    sheet: Sheet
    openings: np.ndarray
    factors: np.ndarray
    crossing: np.ndarray

    @property
    def light_senders(self) -> int:
        """How many senders there are but for the openings: patches and the curtain's cells."""
        return len(self.factors) - len(self.openings)

    @property
    def receivers(self) -> tuple[np.ndarray, np.ndarray]:
        """Positions and normals, [R, 3]."""
        x, n = self.sheet.receivers()
        return np.concatenate([self.charts.positions, x]), np.concatenate([self.charts.normals, n])

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
    charts = make_charts(positions, cell, material)
    low, high = positions.reshape(-1, 3).min(0).astype(float), positions.reshape(-1, 3).max(0).astype(float)
    openings = find_openings(charts, low, high, structure, ctx)
    about = FORMAT, cell, PROXIES, AZIMUTHS_DEG
    path = kept_path("factors", about, sheet.nodes, positions, charts.patches, openings)
    senders = len(charts.patches) + len(sheet.cells()) + len(openings)
    factors = read_kept(path, (2, senders, len(charts.positions) + len(sheet.receivers()[0])), 1.001)
    if factors is None:
        for factors in _compute(ctx, charts, openings, structure, sheet, 1e-4 * float((high - low).max())):
            if isinstance(factors, float):
                yield factors
        keep(path, factors, MOST_FILES)
    yield FormFactors(charts, sheet, openings, *factors)


def _compute(
    ctx: moderngl.Context, charts: Charts, openings: np.ndarray, structure: Structure, sheet: Sheet, offset: float
) -> Iterator[float | np.ndarray]:
    x, n = sheet.receivers()
    receivers = np.zeros((len(charts.positions) + len(x), 2, 4), np.float32)
    receivers[:, 0, :3], receivers[:, 1, :3] = (
        np.concatenate([charts.positions, x]),
        np.concatenate([charts.normals, n]),
    )
    receivers[len(charts.positions) :, 0, 3] = 1.0
    cells = sheet.cells()
    senders = np.zeros((len(charts.patches) + len(cells) + len(openings), 4, 4), np.float32)
    senders[..., :3] = np.concatenate([charts.patches, cells, openings])
    senders[len(charts.patches) : len(charts.patches) + len(cells), 0, 3] = 1.0
    R, S = len(receivers), len(senders)
    given, taken, out = TextureBuffer(ctx, receivers), TextureBuffer(ctx, senders), Buffer(ctx, 8 * R * S)
    nodes = TextureBuffer(ctx, np.concatenate([sheet.nodes, np.zeros((*sheet.nodes.shape[:2], 1))], -1).astype("f4"))
    program = programs(ctx).compute("passes/curtain/factors.comp", None, tracing(structure))
    edges = np.linspace(0, S, SLICES + 1).astype(int)
    step = max(1, PER_DISPATCH // R)
    try:
        for begin, end in pairwise(edges.tolist()):
            for first in range(begin, end, step):
                count = min(step, end - first)
                program.run(
                    R * count, structure.inputs(), receivers=given, senders=taken, Factors=out, receiver_count=R,
                    first=first, sender_count=count, offset=offset, nodes=nodes, cells=PROXIES,
                )  # fmt: skip
                ctx.finish()
            yield end / S
        yield np.moveaxis(np.frombuffer(out.read(8 * R * S), np.float32).reshape(S, R, 2), 2, 0).copy()
    finally:
        for buffer in (given, taken, out, nodes):
            buffer.release()
