"""Light around the room by photons, as paper B announces it: from the lamp and the sky through the moving cloth, kept in a
kd-tree that is built on the GPU, and estimated from the nearest ones.   [Jensen 1996; Zhou, Hou, Wang, Guo 2008]

Each sample of the pixels has photons of its own, found among fewer neighbours from sample to sample, so that both noise and
blur go to 0.   [Knaus, Zwicker 2011, "Progressive photon mapping: a probabilistic approach"]
At some of the photons, evenly spread, irradiance is estimated from many neighbours; hits in the room take the mean of what a few
of those near them have.   [Christensen 1999, "Faster photon map global illumination"]   On the cloth, which lies flat for its
photons, it is estimated at the nodes of a grid.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import moderngl
import numpy as np

from ..accel.points import TEXELS, PointTree
from ..accel.structure import Structure, make_structure, tracing
from ..accel.triangles import Triangles, pack_units
from ..gpu.buffers import Buffer, TextureBuffer
from ..gpu.memo import Last
from ..gpu.programs import programs
from ..light import equirect
from ..light.environment import Environment, rotation_y
from ..tracing.fabrics import fabric_defines
from ..tracing.shot import Shot
from .form_factors import facing_the_room, find_openings
from .portals import CELLS, Emission, emission
from .radiosity import without_suns
from .rims import Rims, find_rims
from .room import Room

SOURCE = "inputs/tracing/indirect_photons.glsl"
CHUNK = 1 << 15  # photons of a dispatch
SLOTS = 24  # arrivals of a photon; a roulette sees to it that less than 1e-4 of the light would have more
GATHERED = 1 << 14  # photons at which irradiance is estimated in the first sample
INTERPOLATED = 12  # of them that a hit takes
NODES = (96, 64)  # of the grid on the cloth, at most, across and down, in the first sample
LEAST_NEIGHBOURS = 8
SHRINKING = 2 / 3  # alpha of Knaus and Zwicker: 1 keeps the radius, 0 the noise
WIDEST = 4.0  # the largest disc, in areas that hold the wanted neighbours in the mean
SURFACE_POINTS = 4096  # from which openings are looked for
SEARCHES = 3  # for a radius, each of which makes it up to 32 times more exact
MOST_PIECES = 4
BYTES = 16 * TEXELS  # of a point


@dataclass(frozen=True)
class Photons:
    """How photons light a picture.

    count : how many begin for each sample of the pixels. neighbours : so many nearest ones make an estimate in the first
    """

    count: int = 400_000
    neighbours: int = 800

    def shrunk(self, sample: int) -> float:
        """The share of the first sample's neighbours that a sample takes."""
        k = np.arange(1, sample + 1)
        return float(np.prod((k + SHRINKING) / (k + 1)))

    def neighbours_of(self, sample: int) -> int:
        """How many neighbours a sample takes."""
        return max(round(self.neighbours * self.shrunk(sample)), LEAST_NEIGHBOURS)


class Grid(NamedTuple):
    """The cloth: its rows and columns of quads, and their sides (across, down), m."""

    rows: int
    columns: int
    spacing: tuple[float, float]


def _size(cloth: Grid) -> tuple[float, float]:
    """Of the flat cloth, m."""
    return cloth.columns * cloth.spacing[0], cloth.rows * cloth.spacing[1]


class SurfacePoints(NamedTuple):
    """Points on a room's surfaces [N, 3], with normals."""

    positions: np.ndarray
    normals: np.ndarray


class PhotonMap:
    """The photons of one room with one curtain, or none."""

    def __init__(self, ctx: moderngl.Context, room: Room, *cloths: Grid):
        """cloths : the pieces of cloth, four at most, as their triangles follow those of the room."""
        self.ctx, self.room, self.cloths = ctx, room, cloths
        self.arrived = 0  # photons in the tree
        scale = float(np.abs(room.positions).max(initial=1e-3))
        edges = room.positions[:, 1:].astype(float) - room.positions[:, :1]
        areas = 0.5 * np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1)
        self._areas = areas
        self._area = float(areas.sum()) + sum((2 * width * height for width, height in map(_size, cloths)), 0.0)
        low, high = room.positions.reshape(-1, 3).min(0), room.positions.reshape(-1, 3).max(0)
        self._box = low.astype(float), high.astype(float)
        self._reach = 0.125 * float(np.linalg.norm(self._box[1] - self._box[0]))  # the largest radius
        widths = [_size(cloth)[0] for cloth in cloths]
        # Discs of one do not reach the next.
        self._lefts = [sum(widths[:k]) + 2.1 * self._reach * k for k in range(len(cloths))]
        ends = [begin + width for begin, width in zip(self._lefts, widths, strict=True)] or [1.0]
        self._scale = 8 * max(scale, ends[-1], *(_size(cloth)[1] for cloth in cloths), 1.0 if not cloths else 0.0)
        self.tree, self._gathered_tree = PointTree(ctx), PointTree(ctx)
        self._slots = TextureBuffer(ctx, 64, "rgba32ui")
        self._found, self._begins = TextureBuffer(ctx, 64, "r32ui"), TextureBuffer(ctx, 64, "r32ui")
        self._photons, self._gathered = TextureBuffer(ctx, 64, "rgba32ui"), TextureBuffer(ctx, 64, "rgba32ui")
        self._node_places, self._node_light = TextureBuffer(ctx, 64, "rgba32ui"), TextureBuffer(ctx, 64, "rgba32ui")
        self._nodes, self._node_count, self._spread = (2, 2), 0, 1.0
        self._radii = Buffer(ctx, 64)
        self._rim_lists, self._rims = TextureBuffer(ctx, 64, "rg32ui"), TextureBuffer(ctx, 64)
        self._portals, self._sky = TextureBuffer(ctx, 64), TextureBuffer(ctx, 64)
        self._openings: np.ndarray | None = None
        self._small_map: Last[np.ndarray] = Last()
        self._emission: Last[Emission] = Last()

    # -- once for a room, a lamp, a sky --------------------------------------------------------------------------

    def prepare(self) -> None:
        """Find the room's openings and the rims of its surfaces, if they are not known yet."""
        if self._openings is not None:
            return
        triangles = Triangles.of(self.ctx, self.room.positions, 1)
        structure = make_structure(self.ctx, "kdtree")
        try:
            structure.build(triangles)
            rims: Rims = find_rims(self.ctx, self.room.positions, structure, self._reach)
            faces = facing_the_room(self.room.positions, structure, self.ctx, self.room.material)
            self._openings = find_openings(self._surface_points(faces), *self._box, structure, self.ctx)
        finally:
            structure.release()
            triangles.release()
        for cloth, begin in zip(self.cloths, self._lefts, strict=True):
            rims = rims.with_sheet(*_size(cloth), self._far, begin)
        ends = np.zeros((max(len(rims.ends), 1), 2, 4), np.float32)
        ends[: len(rims.ends), :, :3] = rims.ends
        self._rims.write(ends)
        self._rim_lists.write(rims.lists.astype(np.uint32))

    def _surface_points(self, faces: np.ndarray) -> SurfacePoints:
        """On triangles [T, 3, 3] that face the room, evenly spread, the same ones each time."""
        corners = faces.astype(float)
        cumulated = np.cumsum(self._areas) / max(float(self._areas.sum()), 1e-30)
        k = np.arange(SURFACE_POINTS)
        t = np.minimum(np.searchsorted(cumulated, (k + 0.5) / SURFACE_POINTS), len(corners) - 1)
        u, v = ((0.5 + k[:, None] * np.array([0.7548776662466927, 0.5698402909980532])) % 1.0).T
        u, v = np.where(u + v > 1, 1 - u, u), np.where(u + v > 1, 1 - v, v)
        a, b, c = (corners[t, i] for i in range(3))
        x = a + u[:, None] * (b - a) + v[:, None] * (c - a)
        n = np.cross(b - a, c - a)
        n /= np.maximum(np.linalg.norm(n, axis=1, keepdims=True), 1e-30)
        return SurfacePoints(x, n)

    @property
    def _far(self) -> float:
        """Where the flat cloth lies."""
        return 0.5 * self._scale

    def emission(self, shot: Shot) -> Emission:
        """The light of a shot that comes into the room, on the GPU too."""
        lamp = shot.lighting.lamp
        key = lamp.position, lamp.intensity, shot.environment, shot.env_rotate, shot.lighting.background
        return self._emission.get(lambda: self._emit(shot), *key)

    def _emit(self, shot: Shot) -> Emission:
        self.prepare()
        assert self._openings is not None
        lamp = shot.lighting.lamp
        found = emission(
            self._openings, self._box, np.array(lamp.position), np.array(lamp.intensity), self._radiance(shot)
        )
        self._portals.write(found.portals)
        self._sky.write(found.sky_draws)
        return found

    def _radiance(self, shot: Shot):
        """The sky's radiance along directions [..., 3], without its suns: the lamp stands for them."""
        environment: Environment | None = shot.environment
        if environment is None:
            return lambda d: np.broadcast_to(np.array(shot.lighting.background, float), d.shape)
        small = self._small_map.get(lambda: without_suns(environment), environment)
        turn = rotation_y(-shot.env_rotate)
        return lambda d: equirect.lookup(small, d @ turn.T)

    # -- each sample ---------------------------------------------------------------------------------------------

    def steps(
        self,
        shot: Shot,
        inputs: Mapping[str, Any],
        structure: Structure,
        photons: Photons,
        sample: int = 0,
        keep_lamp: bool = False,
    ) -> Iterator[dict[str, Any]]:
        """Find the photons of a sample, and the irradiance at some of them; yields after each step, at last the inputs of
        inputs/tracing/indirect_photons.glsl.

        Parameters
        ----------
        inputs : of inputs/tracing/local_light.glsl for this shot, with `beyond` and `offset`
        structure : built of the room and the cloth as it hangs now; of those that find a hit in one dispatch
        keep_lamp : take the lamp's own light too, which a tracer adds itself
        """
        yield from self.arrive(shot, inputs, structure, photons.count, sample, keep_lamp)
        neighbours, shrunk = photons.neighbours_of(sample), photons.shrunk(sample)
        gathered = self.gather(self.tree.sorted_points, self.arrived, neighbours, shrunk)
        # A hit's disc holds INTERPOLATED of them where they are half as dense as in the mean.
        self._spread = 2 * INTERPOLATED * self._area / (np.pi * max(gathered, 1))
        yield {}
        if self.cloths:
            self._lay_nodes(shrunk)
            self.gather(self._node_places, self._node_count, neighbours, out=self._node_light)
            yield {}
        for _ in self._gathered_tree.sort(self._gathered, gathered, self._scale):
            yield {}
        yield self.inputs()

    def arrive(
        self,
        shot: Shot,
        inputs: Mapping[str, Any],
        structure: Structure,
        count: int,
        sample: int = 0,
        keep_lamp: bool = False,
    ) -> Iterator[dict[str, Any]]:
        """Trace so many photons, and build the tree of where they arrive, in steps; parameters as for `steps`."""
        yield from self._trace(inputs, structure, self.emission(shot), count, sample, keep_lamp)
        for _ in self.tree.sort(self._photons, self.arrived, self._scale):
            yield {}

    def _trace(
        self, inputs: Mapping[str, Any], structure: Structure, light: Emission, count: int, sample: int, keep_lamp: bool
    ) -> Iterator[dict[str, Any]]:
        """Trace the photons, and write where they arrive one behind the other."""
        of_lamp, of_sky = light.counts(count)
        count, passes = of_lamp + of_sky, programs(self.ctx)
        self.arrived = 0
        chunk = min(CHUNK, count)
        self._slots.reserve(BYTES * SLOTS * chunk)
        for buffer in (self._found, self._begins):
            buffer.reserve(4 * (chunk + 1))
        names = {
            "portals": self._portals, "sky_draws": self._sky, "portal_count": len(light.portals),
            "sky_cells": CELLS[0] * CELLS[1], "lamp_photons": of_lamp, "sky_photons": of_sky,
            "lamp_inside": light.lamp_inside, "seed": sample + 1, "keep_lamp": keep_lamp,
            "solid_triangles": len(self.room.positions), **self._flat(),
        }  # fmt: skip
        for first in range(0, count, CHUNK):
            n = min(CHUNK, count - first)
            passes.compute("passes/curtain/photon_trace.comp", fabric_defines(inputs), tracing(structure)).run(
                n, structure.inputs(), inputs, names, Slots=self._slots, Found=self._found, slots_each=SLOTS,
                first_photon=first, photon_count=n,
            )  # fmt: skip
            passes.compute("passes/accel/sort_scan.comp").run(
                1, histogram=self._found, Begins=self._begins, entry_count=n + 1
            )
            arrived = int(np.frombuffer(self._begins.read(4, 4 * n), np.uint32)[0])
            self._photons.extend(BYTES * (self.arrived + arrived))
            passes.compute("passes/curtain/photon_pack.comp").run(
                n, slots=self._slots, begins=self._begins, Photons=self._photons, photon_count=n, slots_each=SLOTS,
                first=self.arrived,
            )  # fmt: skip
            self.arrived += arrived
            yield {}

    def gather(
        self,
        queries: TextureBuffer,
        count: int,
        neighbours: int,
        shrunk: float | None = None,
        out: TextureBuffer | None = None,
    ) -> int:
        """Estimate irradiance at points.

        queries : as the tree's points, which carry their places. shrunk : take every so manieth of the points alone, so that
        about GATHERED / shrunk remain. out : where the results are written; None: they are what `gathered` reads

        Returns how many were taken.
        """
        stride = 1 if shrunk is None else max(1, round(count * shrunk / GATHERED))
        taken, out = -(-count // stride), out or self._gathered
        out.reserve(BYTES * max(taken, 1))
        self._radii.reserve(8 * max(taken, 1))
        most = min(WIDEST * neighbours * self._area / (np.pi * max(self.arrived, 1)), self._reach**2)
        names = {
            "queries": queries, "query_count": taken, "stride": stride, "nearest_wanted": neighbours, "nearest_most": most,
            "Radii": self._radii,
        }  # fmt: skip
        for k in range(SEARCHES):
            search = programs(self.ctx).compute("passes/curtain/photon_radius.comp")
            search.run(taken, self.tree.inputs(), names, begins=k == 0)
        programs(self.ctx).compute("passes/curtain/photon_gather.comp").run(
            taken, self.tree.inputs(), names, rim_lists=self._rim_lists, rims=self._rims, Points=out
        )
        return taken

    def _lay_nodes(self, shrunk: float) -> None:
        """Lay the nodes of the grid on each flat piece: those of its front row by row, then of its back."""
        more = shrunk**-0.5
        largest = max(cloth.columns for cloth in self.cloths), max(cloth.rows for cloth in self.cloths)
        across, down = (min(round(most * more), quads) + 1 for most, quads in zip(NODES, largest, strict=True))
        if (across, down) == self._nodes:
            return
        self._nodes, self._node_count = (across, down), 2 * across * down * len(self.cloths)
        data = np.zeros((len(self.cloths), 2, across * down, TEXELS, 4), np.uint32)
        for piece, (cloth, begin) in enumerate(zip(self.cloths, self._lefts, strict=True)):
            width, height = _size(cloth)
            v, u = np.meshgrid(-np.linspace(0, height, down), np.linspace(0, width, across), indexing="ij")
            x, y = begin + u.ravel(), v.ravel()
            for side, sign in enumerate((1.0, -1.0)):
                place = np.stack([x, y, np.full_like(x, sign * self._far)], 1)
                data[piece, side, :, 0, :3] = place.astype(np.float32).view(np.uint32)
                data[piece, side, :, 0, 3] = pack_units(np.array([0.0, 0.0, sign]))
                data[piece, side, :, 1, 3] = 2 * (len(self.room.positions) + piece) + side
        self._node_places.write(data)

    def gathered(self, count: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Read back what `gather` found last of the first points: positions, irradiance [N, 3], radii [N]."""
        data = np.frombuffer(self._gathered.read(BYTES * count), np.float32).reshape(-1, 2, 4)
        squared = np.frombuffer(self._radii.read(8 * count), np.float32).reshape(-1, 2)[:, 0]
        return data[:, 0, :3].copy(), data[:, 1, :3].copy(), np.sqrt(squared)

    def photons(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Read the photons back: positions, W [N, 3], and places [N] int: 2 t and 2 t + 1, the sides of the room's triangle
        t, and behind these those of the cloth, which lies flat."""
        raw = self._photons.read(BYTES * self.arrived)
        data = np.frombuffer(raw, np.float32).reshape(-1, 2, 4)
        places = np.frombuffer(raw, np.uint32).reshape(-1, 2, 4)[:, 1, 3]
        return data[:, 0, :3].copy(), data[:, 1, :3].copy(), places.astype(int)

    def in_room(self) -> np.ndarray:
        """Where the photons are that lie in the room, not on the cloth: [N, 3] float32."""
        x, _, place = self.photons()
        return x[place < 2 * len(self.room.positions)]

    def room_tree(self) -> dict[str, np.ndarray]:
        """The nodes of the tree in which photons of the room lie: axis, count, depth, low and high, as `arrays` has them."""
        tree = self.tree.arrays()
        low, high = self._box
        inside = ((tree["low"] <= high + 1e-3) & (tree["high"] >= low - 1e-3)).all(1)
        return {name: tree[name][inside] for name in ("axis", "count", "depth", "low", "high")}

    def _flat(self) -> dict[str, Any]:
        """The inputs of inputs/tracing/flat_cloth.glsl."""
        cloths = self.cloths or (Grid(1, 1, (1.0, 1.0)),)
        firsts = [
            len(self.room.positions) + 2 * sum(c.rows * c.columns for c in cloths[:k]) for k in range(len(cloths))
        ]

        def four(values, rest):
            return (*values, *[rest] * (MOST_PIECES - len(cloths)))

        return {
            "flat_first": four(firsts, 0x7FFFFFFF), "flat_columns": four((c.columns for c in cloths), 1),
            "flat_across": four((c.spacing[0] for c in cloths), 1.0), "flat_down": four((c.spacing[1] for c in cloths), 1.0),
            "flat_begin": four(self._lefts or (0.0,), 0.0), "flat_far": self._far,
            "cloth_width": four((_size(c)[0] for c in cloths), 1.0), "cloth_height": four((_size(c)[1] for c in cloths), 1.0),
        }  # fmt: skip

    def inputs(self) -> dict[str, Any]:
        """The inputs of inputs/tracing/indirect_photons.glsl."""
        return {
            **self._gathered_tree.inputs(), **self._flat(), "nearest_wanted": INTERPOLATED, "nearest_most": self._spread,
            "cloth_light": self._node_light, "cloth_nodes": self._nodes,
        }  # fmt: skip

    def release(self) -> None:
        """Free the GPU's memory."""
        for thing in (
            self.tree, self._gathered_tree, self._slots, self._found, self._begins, self._photons, self._gathered,
            self._radii, self._node_places, self._node_light, self._rim_lists, self._rims, self._portals, self._sky,
        ):  # fmt: skip
            thing.release()
