"""How far every vertex sees each light: bits of fixed directions, and means over them.   [own, docs/shadows.md]"""

from __future__ import annotations

import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import moderngl
import numpy as np

from ..accel.queries import RayQueries
from ..accel.structure import Traced
from ..color import luminance
from ..geometry.mesh import Mesh
from ..gpu.buffers import TextureBuffer
from ..gpu.memo import Last
from ..gpu.programs import Compute, programs
from ..gpu.shader import flatten
from ..kept import keep_words, kept_path, read_kept_words
from ..light.lights import Lights, SphericalGaussians
from ..twins.visibility import LEAST, gaussian_table, own_directions, world_directions
from .hit_vertices import HitVertices
from .probes import Probes, place_probes
from .sheets import SIGHT_ANY, SIGHT_CLOSEST, Sheets, sight

DIRECTIONS = 256
WORD = 32
MOST_CLASSES = 8
FEWEST = 16  # directions of each probe that must be traced before there is a mean
BROAD = 8  # numbers of the broad light beside the top: four of the low band, four of the middle one
BROAD_FLOOR = 0.02  # of the broad light's mean is added to it everywhere
BROAD_PART = 0.05  # of all light: about the share that one mean of the broad light covers
NARROW = 30.0  # sharpness from which a Gaussian has directions of its own,
OWN = 16  # so many, of all classes together
FLAT, COSINE = 8.0, 1.0  # steepness of the weight of directions
# What an earlier process traced is looked for of so many rays, and kept where they took so many seconds.
WORTH_LOOKING, WORTH_KEEPING = 500_000, 0.5
FORMAT, MOST_FILES = 1, 8  # of these files, some 10 MB each
NEAREST_LAYER = 1 / 3  # of the way to the next layer of cloth: how far rays may start from their own
# Buffers of passes/visibility by their names there, and their texel formats.
DATA = {
    "probe_data": "rgba32f", "x_data": "rgba32f", "light_data": "rgba32f", "direction_data": "rgba32f",
    "entry_data": "rgba32f", "range_data": "rg32i", "least_data": "rgba32f", "row_data": "rg32ui",
    "spread_data": "rg32ui", "bit_data": "r32ui", "hit_data": "r32ui", "sum_data": "rgba32ui",
}  # fmt: skip


class VertexVisibility:
    """V_0 and V_k of the front and the back of every vertex of one mesh.

    `start` takes a mesh, `steps` traces (`done` says how many fixed directions of each probe are), `integrate` makes the
    means under some lights, which then lie in `means`: of each vertex front and back, of each side `groups` words of
    four unorm8: V_0, V_1 .. V_K, the top of the broad light, a gap to the next whole word, and BROAD of its bands.

    Directions count by clamp(`steepness` cos, 0, 1): FLAT for cloth, COSINE for a Lambertian.

    While `hit_vertices` is set, rays also remember the vertex that they end at; `gather` sums the light from there into
    `bounced`.
    """

    def __init__(self, ctx: moderngl.Context, steepness: float = FLAT):
        self.ctx = ctx
        self.steepness = float(steepness)
        self.done = self.groups = 0
        self.version = self.bounced_version = 0  # of `means` and of `bounced`: change when these do
        self.hit_vertices: HitVertices | None = None
        self.sheets: Sheets | None = None  # of cloth that lets light through, if there is any; set before `start`
        self._queries = RayQueries(ctx)
        self._data = {name: TextureBuffer(ctx, 16, texel) for name, texel in DATA.items()}
        self._bounce_sums = TextureBuffer(ctx, 16)
        self.means = TextureBuffer(ctx, 4, "r32ui")
        self.bounced = TextureBuffer(ctx, 16)
        # Rounded to float32, so that the twin and the table have the directions of the rays.
        self.directions = world_directions(DIRECTIONS).astype("f4").astype(float)
        self._next_direction = 0  # of those that `move` traces again
        self._sharp: Lights | None = None  # whose narrow Gaussians' own directions are traced
        self._narrow = np.zeros(0, int)  # which those are
        self._integrated: Last[None] = Last()
        self._traced: list[np.ndarray] = []  # of each class: its fixed directions, then those of narrow Gaussians

    def start(self, mesh: Mesh, structure: Traced, original: Mesh | None = None, classes: int | None = None) -> None:
        """Forget all visibility and begin with another mesh.

        Parameters
        ----------
        structure : built, over the triangles that hide light (`glcloth.accel`)
        original, classes : see `place_probes`
        """
        self.start_at(place_probes(mesh, original, classes=classes), structure)

    def start_at(self, probes: Probes, structure: Traced) -> None:
        """As `start`, from given probes."""
        self.probes, self._structure = probes, structure
        self.done, self._next_direction, self._sharp = 0, 0, None
        self._integrated.forget()
        self._upload_probes(self._offset_between_layers())
        count, data = len(probes.points), self._data
        data["bit_data"].write(np.zeros((self.share // self.word, count), "u4"))
        if self.hit_vertices is not None:
            data["hit_data"].reserve(4 * self.share * count)
        self._write_directions([])
        spread = probes.spread
        data["row_data"].write(np.stack([spread.indptr[:-1], spread.indptr[1:]], 1).astype("u4"))
        data["spread_data"].write(np.stack([spread.indices.astype("u4"), spread.data.astype("f4").view("u4")], 1))

    def move(self, mesh: Mesh, structure: Traced, count: int = 8) -> None:
        """Follow the mesh to a new pose: visibility stays, but `count` of each probe's directions are traced again, the
        oldest first."""
        self.probes, self._structure = self.probes.moved(mesh), structure
        self._upload_probes(self.probes.offset)
        self._sharp = None
        for _ in self.steps():
            pass
        self._trace(self._next_direction, self._next_direction + count)
        self._next_direction = (self._next_direction + count) % self.share
        self._integrated.forget()

    def _upload_probes(self, offset: np.ndarray) -> None:
        probes = self.probes
        records = np.zeros((len(probes.points), 2, 4), "f4")
        records[:, 0, :3], records[:, 1, :3] = probes.points, probes.normals
        records[:, 0, 3], records[:, 1, 3] = offset.T
        self._data["probe_data"].write(records)
        self._data["x_data"].write(probes.tangents.astype("f4"))

    def _offset_between_layers(self) -> np.ndarray:
        """The probes' offsets [P, 2], at most a third of the way to the next layer."""
        probes, offset = self.probes, self.probes.offset.copy()
        for side, sign in ((0, 1.0), (1, -1.0)):
            far = offset[:, side] / NEAREST_LAYER
            # Anything nearer than this is the triangles about the vertex itself.
            near = self._queries.closest_hit(
                self._structure, probes.points, sign * probes.normals, 0.05 * offset[:, side], far
            )
            offset[:, side] = np.minimum(offset[:, side], NEAREST_LAYER * near.t)
        return offset

    # -- tracing -----------------------------------------------------------------------------------------------------

    @property
    def classes(self) -> int:
        """How many classes the probes are of."""
        return len(self.probes.first) - 1

    @property
    def share(self) -> int:
        """Fixed directions of each class."""
        return max(DIRECTIONS // self.classes, WORD)

    @property
    def word(self) -> int:
        """Directions whose visibility is one word of `bit_data`: a bit each, or a byte where cloth lets light through."""
        return WORD if self.sheets is None else 4

    @property
    def complete(self) -> bool:
        """True when all fixed directions are traced."""
        return self.done == self.share

    def _write_directions(self, own: list[np.ndarray]) -> None:
        """Upload the directions of each class: its own share of the fixed ones, and of each array in `own`."""
        C = self.classes
        self._traced = [
            np.concatenate([self.directions[c * self.share :][: self.share], *(d[c::C] for d in own)])
            .astype("f4")
            .astype(float)
            for c in range(C)
        ]
        padded = np.zeros((C, len(self._traced[0]), 4), "f4")
        padded[..., :3] = self._traced
        self._data["direction_data"].write(padded)

    def _trace(self, first: int, last: int) -> None:
        """Trace directions number first to last - 1 of every class, all in one word of bits."""
        path, defines, virtual, rays = self._sight(self.hit_vertices if last <= self.share else None)
        program = programs(self.ctx).compute(path, defines, virtual)
        inputs = rays | {"Bits": self._data["bit_data"], "Hits": self._data["hit_data"]}
        part = {"first_direction": first, "last_direction": last}
        self._run_classes(program, inputs, class_directions=len(self._traced[0]), **part)

    def _sight(self, hits: HitVertices | None) -> tuple[str, dict[str, int], dict[str, str], dict[str, Any]]:
        """The pass that asks what is seen, and with `hits` where rays end: its file, defines, virtual includes, inputs."""
        path = "passes/visibility/trace.comp" if hits is None else "passes/visibility/hits.comp"
        opaque = SIGHT_ANY if hits is None else SIGHT_CLOSEST
        defines, virtual, rays = sight(self._structure, self.sheets, opaque)
        return path, defines, virtual, rays | ({} if hits is None else hits.inputs())

    def step(self, count: int = WORD) -> int:
        """Trace at most `count` more directions of each probe; returns how many."""
        first = self.done
        last = min(first + count, (first // WORD + 1) * WORD, self.share)
        if last > first:
            self._trace(first, last)
            self.done = last
        return last - first

    def steps(self, lights: Lights | None = None, count: int = WORD) -> Iterator[int]:
        """Trace the missing directions, `count` at a time: the fixed ones, then the own ones of `lights`' narrow
        Gaussians. Yields after each step how many of each probe's are traced."""
        if not self.complete:
            yield from self._kept_or_traced(self.done, self.share, count)
        if lights is None or self._sharp is lights:
            return
        gaussians = lights.gaussians
        self._sharp = None
        self._narrow = np.flatnonzero(gaussians.sharpness >= NARROW)
        self._write_directions([own_directions(gaussians.axis[k], gaussians.sharpness[k], OWN) for k in self._narrow])
        words = -(-len(self._traced[0]) // self.word)
        self._data["bit_data"].extend(4 * words * len(self.probes.points))
        if self.share < len(self._traced[0]):
            yield from self._kept_or_traced(self.share, len(self._traced[0]), count)
        self._sharp = lights

    def _kept_or_traced(self, first: int, end: int, count: int) -> Iterator[int]:
        """Trace directions number first to end - 1 of every class, `count` at a time, or find them on disk; the fixed ones,
        or all that follow these. Yields how many are traced."""
        fixed = end <= self.share
        path = self._path(fixed, end)
        kept = read_kept_words(path, [shape for _, _, shape in self._words(fixed, end)]) if path else None
        if kept is not None:
            for (name, at, _), words in zip(self._words(fixed, end), kept, strict=True):
                self._data[name].write(words, at)
            self.done = self.share
            yield end
            return
        spent, began = 0.0, first
        while first < end:
            begin, last = time.perf_counter(), min(first + count, (first // WORD + 1) * WORD, end)
            self._trace(first, last)
            self.ctx.finish()  # so that progress tells the truth and Ctrl-C is heard
            spent += time.perf_counter() - begin
            first = last
            if fixed:
                self.done = last
            yield last
        of_all = end if fixed else end - self.share
        if path and spent * of_all > WORTH_KEEPING * (end - began):
            found = [np.frombuffer(self._data[name].read(4 * int(np.prod(shape)), at), np.uint32).reshape(shape)
                     for name, at, shape in self._words(fixed, end)]  # fmt: skip
            keep_words(path, found, MOST_FILES)

    # -- on disk -----------------------------------------------------------------------------------------------------

    def _words(self, fixed: bool, end: int) -> list[tuple[str, int, tuple[int, ...]]]:
        """Where the words of the fixed directions lie, or of those that follow: buffer, first byte, shape."""
        count, begin = len(self.probes.points), 0 if fixed else self.share // self.word
        words: list[tuple[str, int, tuple[int, ...]]] = [
            ("bit_data", 4 * count * begin, (-(-end // self.word) - begin, count))
        ]
        if fixed and self.hit_vertices is not None:
            words.append(("hit_data", 0, (self.share, count)))
        return words

    def _path(self, fixed: bool, end: int) -> Path | None:
        """The file of what these rays meet, named by all that it depends on; None: they are too few to be looked for."""
        if self.sheets is not None or len(self.probes.points) * self.share < WORTH_LOOKING:
            return None
        path, defines, virtual, inputs = self._sight(self.hit_vertices if fixed else None)
        triangles = self._structure.triangles
        assert triangles is not None
        own = [self._data[name] for name in ("probe_data", "x_data", "direction_data")]
        # What the triangles are is in their buffers; the structure is made of them.
        hits = list(self.hit_vertices.inputs().values()) if fixed and self.hit_vertices is not None else []
        about = [one.read(one.written) for one in (*own, *hits) if isinstance(one, TextureBuffer)]
        about.append(triangles.corners.read(48 * triangles.count))
        numbers = sorted(
            (name, np.asarray(v).tolist()) for name, v in inputs.items() if not isinstance(v, TextureBuffer)
        )
        driver = self.ctx.info["GL_RENDERER"], self.ctx.info["GL_VERSION"]
        text, _ = flatten(path, defines, virtual)
        folder = "visibility" if fixed else "visibility_own"
        return kept_path(folder, FORMAT, driver, text, numbers, end, self.probes.first, *about)

    def total(self, lights: Lights | None = None) -> int:
        """How many directions of each probe `steps` traces in all."""
        narrow = int((lights.gaussians.sharpness >= NARROW).sum()) if lights is not None else 0
        return self.share + narrow * OWN // self.classes

    # -- means -------------------------------------------------------------------------------------------------------

    def integrate(self, lights: Lights, broad: np.ndarray | None, above: bool = False) -> None:
        """Make the means under these lights, from as many directions as are traced; nothing when they are made.

        `broad`: how much [K] of each Gaussian a method sums with others before it knows V. That light's visibility
        follows V_K as nine means over parts of the surface frame (`twins.visibility.from_bands`); None: not at all.
        `above`: that is of the light from above the horizon alone (inputs/visibility/seen_occluders.glsl).
        """
        key = self.done, self._sharp is lights, None if broad is None else broad.tobytes(), above
        self._integrated.get(lambda: self._integrate(lights, broad, above), lights, *key)

    def _integrate(self, lights: Lights, broad: np.ndarray | None, above: bool) -> None:
        data, vertices = self._data, self.probes.spread.shape[0]
        tables = [self._table(c, lights, self._sharp is lights) for c in range(self.classes)]
        first_broad = tables[0].shape[1] // 4
        self.groups = first_broad + (0 if broad is None else BROAD // 4)
        data["sum_data"].reserve(32 * self.groups * len(self.probes.points))
        self.means.reserve(8 * self.groups * vertices)
        self._write_entries(tables)
        program = programs(self.ctx).compute("passes/visibility/mean.comp", self._bytes)
        sizes = {"last_item": vertices, "group_count": self.groups, "steepness": self.steepness}
        self._run_classes(program, sizes, first_broad, Sums=data["sum_data"])
        sums = sum(table.sum(0) for table in tables)
        if broad is not None:
            there = self._sum_broad(lights, broad, first_broad, above)
            sums = np.append(sums, np.full(BROAD, BROAD_PART * there))
            sums[top_number(len(lights.gaussians))] = BROAD_PART * there
        data["least_data"].write(np.where(sums > 0.0, LEAST * sums, 1.0).astype("f4"))
        program = programs(self.ctx).compute("passes/visibility/spread.comp")
        program.run((vertices, self.groups), data, sizes, Means=self.means)
        self.version += 1

    @property
    def _bytes(self) -> dict[str, int]:
        """Defines of passes that read what was traced."""
        return {} if self.sheets is None else {"SHEER": 1}

    def _write_entries(self, tables: list[np.ndarray]) -> None:
        """Upload the directions that count for each four columns of the tables of all classes."""
        entries, ranges, begin = [], [], 0
        for directions, table in zip(self._traced, tables, strict=True):
            for column in range(0, table.shape[1], 4):
                entries.append(_entries(directions[: len(table)], table[:, column : column + 4]))
                ranges.append((begin, begin + len(entries[-1])))
                begin = ranges[-1][1]
        self._data["entry_data"].write(np.concatenate(entries))
        self._data["range_data"].write(np.array(ranges, "i4"))

    def _sum_broad(self, lights: Lights, broad: np.ndarray, first_broad: int, above: bool) -> float:
        """Sum the broad light that the probes see; returns how much of it there is, over the traced directions."""
        gaussians = lights.gaussians
        light = SphericalGaussians(gaussians.axis, gaussians.sharpness, gaussians.amplitude * broad[:, None])
        weight = luminance(np.maximum(light.radiance(self.directions), 0.0))
        # Where there is no such light, V still goes on smoothly from where there is.
        weight += BROAD_FLOOR * weight.mean() + 1e-30
        if above:
            weight *= self.directions[:, 1] > 0.0
        used = weight[: self.classes * self.share].reshape(self.classes, self.share)[:, : self.done]
        weight /= weight.max()
        records = np.zeros((DIRECTIONS, 4), "f4")
        records[:, :3], records[:, 3] = self.directions, weight
        self._data["light_data"].write(records)
        program = programs(self.ctx).compute("passes/visibility/broad.comp", self._bytes)
        numbers = {"group": first_broad, "top_number": top_number(len(gaussians)), "group_count": self.groups}
        counts = {"share": self.share, "direction_count": self.done}
        self._run_classes(program, numbers | counts, Sums=self._data["sum_data"])
        return float(used.sum())  # a view: scaled, too

    def _table(self, c: int, lights: Lights, sharp: bool) -> np.ndarray:
        """The weights of the traced directions [n] of a class in each number of `means` before the broad light's."""
        gaussians = lights.gaussians
        fixed = self._traced[c][: self.done]
        # As sharp as the fixed directions of all classes together can tell.
        table = gaussian_table(fixed, gaussians.axis, gaussians.sharpness, self.done * self.classes)
        gap = np.zeros((len(fixed), broad_number(len(gaussians)) - table.shape[1]))
        table = np.concatenate([table, gap], 1)
        if sharp:
            own = np.zeros((len(self._traced[c]) - self.done, table.shape[1]))
            table[:, 1 + self._narrow] = 0.0
            each = OWN // self.classes
            for place, k in enumerate(self._narrow):
                own[each * place :][:each, 1 + k] = 1.0
            table = np.concatenate([table, own])
        return table

    def gather(self, radiance: TextureBuffer, flat_share: float) -> None:
        """Make `bounced` from the vertices that the fixed directions ended at: of each vertex front and back the mean
        radiance that comes back to it, and the mean of its luminance times its direction.

        Parameters
        ----------
        radiance : of all vertices in the numbering of `hit_vertices`, front and back; and how upright it is (`Given`)
        flat_share : of the weight of directions: `response_to` of glsl/trace/visibility.glsl
        """
        vertices = self.probes.spread.shape[0]
        self._bounce_sums.reserve(64 * len(self.probes.points))
        self.bounced.reserve(64 * vertices)
        counts = {"class_directions": len(self._traced[0]), "direction_count": self.done}
        program = programs(self.ctx).compute("passes/visibility/bounce_gather.comp")
        assert self.hit_vertices is not None
        inputs = counts | self.hit_vertices.inputs()
        self._run_classes(program, inputs, radiance_data=radiance, Sums=self._bounce_sums, flat_share=flat_share)
        program = programs(self.ctx).compute("passes/visibility/bounce_spread.comp")
        own = {"sum_data": self._bounce_sums, "Means": self.bounced}
        program.run(vertices, self._data, own, vertex_count=vertices)
        self.bounced_version += 1

    # -- reading back ------------------------------------------------------------------------------------------------

    def bits(self) -> list[np.ndarray]:
        """Read back which of their directions the probes of each class see: bool [P_c, done]. Where cloth is sheer they see
        shares, which are none."""
        assert self.sheets is None
        count = len(self.probes.points)
        words = np.frombuffer(self._data["bit_data"].read(4 * count * (self.share // WORD)), "<u4").reshape(-1, count)
        bits = np.unpackbits(words.T.copy().view("u1"), axis=1, bitorder="little")[:, : self.done].astype(bool)
        return [bits[a:b] for a, b in zip(self.probes.first[:-1], self.probes.first[1:], strict=True)]

    def class_directions(self) -> list[np.ndarray]:
        """The fixed directions [share, 3] of each class."""
        return [directions[: self.share] for directions in self._traced]

    def values(self) -> np.ndarray:
        """Read back the means: float [V, 2, 4 groups]."""
        vertices = self.probes.spread.shape[0]
        data = np.frombuffer(self.means.read(8 * self.groups * vertices), "u1")
        return data.reshape(vertices, 2, -1) / 255.0

    # -- the machinery -----------------------------------------------------------------------------------------------

    def _run_classes(
        self, program: Compute, inputs: dict[str, Any] | None = None, layers: int = 1, **names: Any
    ) -> None:
        """Run a program for all probes of all classes, `layers` times."""
        first = self.probes.first
        padded = np.append(first, np.repeat(first[-1:], MOST_CLASSES + 1 - len(first)))
        names |= {"first_probe": padded, "probe_count": int(first[-1])}
        program.run((int(np.diff(first).max()), self.classes, layers), self._data, inputs or {}, **names)

    def release(self) -> None:
        """Free the GPU's memory."""
        for buffer in (*self._data.values(), self._bounce_sums, self.means, self.bounced):
            buffer.release()
        self._queries.release()


def top_number(gaussians: int) -> int:
    """The number of the broad light's mean at the top, after so many Gaussians."""
    return 1 + gaussians


def broad_number(gaussians: int) -> int:
    """The number of the first of the broad light's means in the bands."""
    return -(-(2 + gaussians) // 4) * 4


def sun_number(gaussians: int) -> int:
    """The number of the first sun."""
    return broad_number(gaussians) + BROAD


def _entries(directions: np.ndarray, table: np.ndarray) -> np.ndarray:
    """The directions that count for four columns of a table: [E, 8] float32, each with its number and weights."""
    number = np.flatnonzero(table.any(1))
    entries = np.empty((len(number), 8), "f4")
    entries[:, :3], entries[:, 3], entries[:, 4:] = directions[number], number, table[number]
    return entries
