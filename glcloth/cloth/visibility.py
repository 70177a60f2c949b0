"""What every vertex sees of each light: bits of fixed directions, and means over them.   [own, docs/shadows.md]"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from .. import shader
from ..accel.queries import RayQueries
from ..color import luminance
from ..gpu import TextureBuffer
from ..lights import Lights, SphericalGaussians
from ..mesh import Mesh
from ..reference.visibility import LEAST, gaussian_table, own_directions, world_directions
from .probes import Probes, place_probes

DIRECTIONS = 256
WORD = 32
FEWEST = 16  # directions of each probe that must be traced before there is a mean
BROAD = 12  # numbers of the broad light: four of the low band, four of the middle one, four times the top
BROAD_FLOOR = 0.02  # of the broad light's mean is added to it everywhere
BROAD_PART = 0.05  # of all light: about what one mean of the broad light is of
NARROW = 30.0  # sharpness from which a Gaussian has directions of its own,
OWN = 16  # so many, of all classes together
FLAT, COSINE = 8.0, 1.0  # steepness of the weight of directions
NEAREST_LAYER = 1 / 3  # of the way to the next layer of cloth: how far rays may start from their own


class VertexVisibility:
    """V_0 and V_k of the front and the back of every vertex of one mesh.

    `start` takes a mesh, `steps` traces (`done` says how many fixed directions of each probe are), `integrate` makes the
    means under some lights, which then lie in `means`: of each vertex front and back, of each side `groups` words of
    four unorm8: V_0, V_1 .. V_K, a gap to the next whole word, and BROAD of the broad light.

    Directions count by clamp(`steepness` cos, 0, 1): FLAT for cloth, COSINE for a Lambertian.
    """

    def __init__(self, ctx, steepness: float = FLAT):
        self.ctx = ctx
        self.steepness = float(steepness)
        self.done = self.groups = 0
        self.version = 0  # of the means: changes when they do
        self.probes: Probes | None = None
        self._programs: dict[str, object] = {}
        self._queries = RayQueries(ctx)
        self._probe_data = TextureBuffer(ctx, 32)
        self._x_data = TextureBuffer(ctx, 16)
        self._light_data = TextureBuffer(ctx, 16 * DIRECTIONS)
        self._row_data = TextureBuffer(ctx, 8, "rg32ui")
        self._spread_data = TextureBuffer(ctx, 8, "rg32ui")
        self._bits = TextureBuffer(ctx, 4, "r32ui")
        self._entries = TextureBuffer(ctx, 16)
        self._sums = TextureBuffer(ctx, 4, "r32ui")
        self.means = TextureBuffer(ctx, 4, "r32ui")
        self._direction_data = TextureBuffer(ctx, 16 * DIRECTIONS)
        # As float32, so that the twin and the table see what the rays follow.
        self.directions = world_directions(DIRECTIONS).astype("f4").astype(float)
        self._structure = self._lights = self._sharp = self._state = None
        self._traced: list[np.ndarray] = []  # of each class: its fixed directions, then those of narrow Gaussians

    def start(self, mesh: Mesh, structure, original: Mesh | None = None, classes: int | None = None) -> None:
        """Forget what was seen and look out from another mesh.

        Parameters
        ----------
        structure : built, over the triangles that hide light (`glcloth.accel`)
        original, classes : see `place_probes`
        """
        self.start_at(place_probes(mesh, original, classes=classes), structure)

    def start_at(self, probes: Probes, structure) -> None:
        """As `start`, from given probes."""
        self.probes, self._structure = probes, structure
        self.done, self._turn, self._lights, self._sharp, self._state = 0, 0, None, None, None
        self._upload_probes(self._offset_between_layers())
        count = len(probes.points)
        self._bits.write(np.zeros((self.share // WORD, count), "u4"))
        self._write_directions([])
        spread = probes.spread
        self._row_data.write(np.stack([spread.indptr[:-1], spread.indptr[1:]], 1).astype("u4"))
        self._spread_data.write(np.stack([spread.indices.astype("u4"), spread.data.astype("f4").view("u4")], 1))

    def move(self, mesh: Mesh, structure, count: int = 8) -> None:
        """Follow the mesh to a new pose: what was seen stays, but for `count` of each probe's directions, which are
        traced again; the oldest first."""
        self.probes, self._structure = self.probes.moved(mesh), structure
        self._upload_probes(self.probes.offset)
        self._sharp = None
        for _ in self.steps():
            pass
        self._trace(self._turn, self._turn + count)
        self._turn = (self._turn + count) % self.share
        self._state = None

    def _upload_probes(self, offset: np.ndarray) -> None:
        probes = self.probes
        records = np.zeros((len(probes.points), 2, 4), "f4")
        records[:, 0, :3], records[:, 1, :3] = probes.points, probes.normals
        records[:, 0, 3], records[:, 1, 3] = offset.T
        self._probe_data.write(records)
        self._x_data.write(probes.tangents.astype("f4"))

    def _offset_between_layers(self) -> np.ndarray:
        """The probes' offsets [P, 2], at most a third of the way to the next layer."""
        probes, offset = self.probes, self.probes.offset.copy()
        for side, sign in ((0, 1.0), (1, -1.0)):
            far = offset[:, side] / NEAREST_LAYER
            # What is nearer than this is the triangles about the vertex itself.
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
        self._direction_data.write(padded)

    def _trace(self, first: int, last: int) -> None:
        """Trace directions number first to last - 1 of every class, all in one word of bits."""
        program = self._program("trace", {"accel.glsl": self._structure.source})
        self._structure.bind(program)
        self._probe_data.bind(11)
        self._direction_data.bind(12)
        self._bits.buffer.bind_to_storage_buffer(0)
        for c in range(self.classes):
            self._run(
                program,
                *self.probes.first[c : c + 2],
                direction_base=c * len(self._traced[0]),
                first_direction=first,
                last_direction=last,
            )
        self.ctx.memory_barrier()

    def step(self, count: int = WORD) -> int:
        """Trace at most `count` more directions of each probe; returns how many."""
        first = self.done
        last = min(first + count, (first // WORD + 1) * WORD, self.share)
        if last > first:
            self._trace(first, last)
            self.done = last
        return last - first

    def steps(self, lights: Lights | None = None, count: int = WORD) -> Iterator[int]:
        """What is left to trace, `count` directions at a time: the fixed ones, then those of the narrow Gaussians of
        `lights`. Yields after each step how many of each probe's are traced."""
        while not self.complete:
            self.step(count)
            self.ctx.finish()  # so that progress tells the truth and Ctrl-C is heard
            yield self.done
        if lights is None or self._sharp is lights:
            return
        gaussians = lights.gaussians
        self._sharp = None
        self._narrow = np.flatnonzero(gaussians.sharpness >= NARROW)
        self._write_directions([own_directions(gaussians.axis[k], gaussians.sharpness[k], OWN) for k in self._narrow])
        self._grow_bits(-(-len(self._traced[0]) // WORD))
        first = self.share
        while first < len(self._traced[0]):
            last = min(first + count, (first // WORD + 1) * WORD, len(self._traced[0]))
            self._trace(first, last)
            self.ctx.finish()
            first = last
            yield last
        self._sharp = lights

    def total(self, lights: Lights | None = None) -> int:
        """How many directions of each probe `steps` traces in all."""
        narrow = int((lights.gaussians.sharpness >= NARROW).sum()) if lights is not None else 0
        return self.share + narrow * OWN // self.classes

    def _grow_bits(self, words: int) -> None:
        """Make room for so many words of bits of every probe; keep what is traced."""
        size = 4 * words * len(self.probes.points)
        if size > self._bits.size:
            kept = self._bits.buffer.read()
            self._bits.reserve(size)
            self._bits.write(kept)

    # -- means -------------------------------------------------------------------------------------------------------

    def integrate(self, lights: Lights, broad: np.ndarray | None) -> None:
        """Make the means under these lights, from as many directions as are traced; nothing when they are made.

        `broad`: how much [K] of each Gaussian a method sums with others before it knows V. That light's visibility
        follows V_K as nine means over parts of the surface frame (`reference.visibility.from_bands`); None: not at all.
        """
        sharp = self._sharp is lights
        state = self.done, sharp, None if broad is None else broad.tobytes()
        if self._lights is lights and self._state == state:
            return
        tables = [self._table(c, lights, sharp) for c in range(self.classes)]
        first_broad = tables[0].shape[1] // 4
        self.groups = first_broad + (0 if broad is None else BROAD // 4)
        words, P, V = 4 * self.groups, len(self.probes.points), self.probes.spread.shape[0]
        self._sums.reserve(8 * words * P)
        self.means.reserve(8 * self.groups * V)
        entries, firsts = [], []
        for directions, table in zip(self._traced, tables, strict=True):
            first, one = _entries(directions[: len(table)], table)
            firsts.append(first + sum(len(e) for e in entries))
            entries.append(one)
        self._entries.write(np.concatenate(entries))
        program = self._program("mean")
        for unit, buffer in enumerate((self._bits, self._entries, self._probe_data), 9):
            buffer.bind(unit)
        self._sums.buffer.bind_to_storage_buffer(0)
        for c, first in enumerate(firsts):
            for group in range(first_broad):
                self._run(
                    program,
                    *self.probes.first[c : c + 2],
                    group=group,
                    group_count=self.groups,
                    steepness=self.steepness,
                    first=tuple(map(int, first[4 * group : 4 * group + 4])),
                    last=tuple(map(int, first[4 * group + 1 : 4 * group + 5])),
                )
        sums = sum(table.sum(0) for table in tables)
        if broad is not None:
            there = self._sum_broad(lights, broad, first_broad)
            sums = np.append(sums, np.full(BROAD, BROAD_PART * there))
        self.ctx.memory_barrier()
        least = np.where(sums > 0.0, LEAST * sums, 1.0).reshape(-1, 4)
        program = self._program("spread")
        for unit, buffer in enumerate((self._sums, self._row_data, self._spread_data), 9):
            buffer.bind(unit)
        self.means.buffer.bind_to_storage_buffer(0)
        for group in range(self.groups):
            self._run(program, 0, V, group=group, group_count=self.groups, least=tuple(map(float, least[group])))
        self.ctx.memory_barrier()
        self._lights, self._state = lights, state
        self.version += 1

    def _sum_broad(self, lights: Lights, broad: np.ndarray, first_broad: int) -> float:
        """Sum what the probes see of the broad light; returns how much of it there is, over all directions."""
        gaussians = lights.gaussians
        light = SphericalGaussians(gaussians.axis, gaussians.sharpness, gaussians.amplitude * broad[:, None])
        weight = luminance(np.maximum(light.radiance(self.directions), 0.0))
        # Where there is no such light, V still goes on smoothly from where there is.
        weight = (weight + BROAD_FLOOR * weight.mean() + 1e-30) / (weight.max() + 1e-30)
        records = np.zeros((DIRECTIONS, 4), "f4")
        records[:, :3], records[:, 3] = self.directions, weight
        self._light_data.write(records)
        program = self._program("broad")
        for unit, buffer in enumerate((self._bits, self._light_data, self._probe_data, self._x_data), 9):
            buffer.bind(unit)
        for c in range(self.classes):
            self._run(
                program,
                *self.probes.first[c : c + 2],
                group=first_broad,
                group_count=self.groups,
                first_direction=c * self.share,
                direction_count=self.done,
            )
        return float(weight.sum())

    def _table(self, c: int, lights: Lights, sharp: bool) -> np.ndarray:
        """What the traced directions [n] of a class weigh in each number of `means` before the broad light's."""
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

    # -- reading back ------------------------------------------------------------------------------------------------

    def bits(self) -> list[np.ndarray]:
        """Read back what the probes of each class see of its directions: bool [P_c, done]."""
        count = len(self.probes.points)
        words = np.frombuffer(self._bits.buffer.read(4 * count * (self.share // WORD)), "<u4").reshape(-1, count)
        bits = np.unpackbits(words.T.copy().view("u1"), axis=1, bitorder="little")[:, : self.done].astype(bool)
        return [bits[a:b] for a, b in zip(self.probes.first[:-1], self.probes.first[1:], strict=True)]

    def class_directions(self) -> list[np.ndarray]:
        """The fixed directions [share, 3] of each class."""
        return [directions[: self.share] for directions in self._traced]

    def values(self) -> np.ndarray:
        """Read back the means: float [V, 2, 4 groups]."""
        vertices = self.probes.spread.shape[0]
        data = np.frombuffer(self.means.buffer.read(8 * self.groups * vertices), "u1")
        return data.reshape(vertices, 2, -1) / 255.0

    # -- the machinery -----------------------------------------------------------------------------------------------

    def _program(self, stage: str, virtual: dict | None = None):
        if stage not in self._programs:
            virtual = {"count.glsl": "passes/count_none.glsl", **(virtual or {})}
            self._programs[stage] = shader.compute(self.ctx, f"passes/visibility_{stage}.comp", None, virtual)
        return self._programs[stage]

    def _run(self, program, begin: int, end: int, /, **uniforms) -> None:
        """Run a program for the probes or vertices number `begin` to `end` - 1."""
        if end > begin:
            probes = len(self.probes.points)
            shader.set_uniforms(program, first_item=int(begin), last_item=int(end), probe_count=probes, **uniforms)
            program.run(-(-int(end - begin) // 64))

    def release(self) -> None:
        """Free the GPU's memory."""
        buffers = (
            self._probe_data,
            self._x_data,
            self._light_data,
            self._row_data,
            self._spread_data,
            self._bits,
            self._entries,
            self._direction_data,
        )
        for thing in (*buffers, self._sums, self.means, self._queries, *self._programs.values()):
            thing.release()


def broad_number(gaussians: int) -> int:
    """The number of the first of the broad light's means, after those of so many Gaussians."""
    return -(-(1 + gaussians) // 4) * 4


def sun_number(gaussians: int) -> int:
    """The number of the first sun."""
    return broad_number(gaussians) + BROAD


def _entries(directions: np.ndarray, table: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Per column of a table the directions that count: where those of a column begin [>= columns + 1], and for each the
    direction and its number + G / 2, [E, 4] float32. Columns beyond the table's have none."""
    column, number = np.nonzero(table.T)
    entries = np.empty((len(column), 4), "f4")
    entries[:, :3] = directions[number]
    entries[:, 3] = number + 0.5 * table[number, column]
    first = np.searchsorted(column, np.arange(table.shape[1] + 8))
    return first.astype(int), entries
