"""What every vertex sees of each light: bits of fixed directions, and means over them.   [own, docs/shadows.md]"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ..accel.queries import RayQueries
from ..color import luminance
from ..geometry.mesh import Mesh
from ..gpu import shader
from ..gpu.buffers import TextureBuffer
from ..light.lights import Lights, SphericalGaussians
from ..twins.visibility import LEAST, gaussian_table, own_directions, world_directions
from .probes import Probes, place_probes

DIRECTIONS = 256
WORD = 32
MOST_CLASSES = 8
FEWEST = 16  # directions of each probe that must be traced before there is a mean
BROAD = 8  # numbers of the broad light beside the top: four of the low band, four of the middle one
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
    four unorm8: V_0, V_1 .. V_K, the top of the broad light, a gap to the next whole word, and BROAD of its bands.

    Directions count by clamp(`steepness` cos, 0, 1): FLAT for cloth, COSINE for a Lambertian.
    """

    def __init__(self, ctx, steepness: float = FLAT):
        self.ctx = ctx
        self.steepness = float(steepness)
        self.done = self.groups = 0
        self.version = 0  # of the means: changes when they do
        self.probes: Probes | None = None
        self._program = shader.Computes(ctx)
        self._queries = RayQueries(ctx)
        self._probe_data = TextureBuffer(ctx, 32)
        self._x_data = TextureBuffer(ctx, 16)
        self._light_data = TextureBuffer(ctx, 16 * DIRECTIONS)
        self._row_data = TextureBuffer(ctx, 8, "rg32ui")
        self._spread_data = TextureBuffer(ctx, 8, "rg32ui")
        self._bits = TextureBuffer(ctx, 4, "r32ui")
        self._entries = TextureBuffer(ctx, 16)
        self._ranges = TextureBuffer(ctx, 8, "rg32i")
        self._least = TextureBuffer(ctx, 16)
        self._sums = TextureBuffer(ctx, 16, "rgba32ui")
        self.means = TextureBuffer(ctx, 4, "r32ui")
        self._direction_data = TextureBuffer(ctx, 16 * DIRECTIONS)
        self.places = None  # cloth.places.Places: what rays meet is remembered, if it is set
        self._hits = TextureBuffer(ctx, 4, "r32ui")
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
        if self.places is not None:
            self._hits.reserve(4 * self.share * count)
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
        remembered = self.places is not None and last <= self.share
        program = self._program(
            "passes/visibility/hits.comp" if remembered else "passes/visibility/trace.comp",
            {"accel.glsl": self._structure.source},
        )
        self._structure.bind(program)
        if remembered:
            self.places.bind(program, 10, 13)
            self._hits.buffer.bind_to_storage_buffer(1)
        self._probe_data.bind(11)
        self._direction_data.bind(12)
        self._bits.buffer.bind_to_storage_buffer(0)
        size = len(self._traced[0])
        self._run_classes(program, class_directions=size, first_direction=first, last_direction=last)
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

    def integrate(self, lights: Lights, broad: np.ndarray | None, above: bool = False) -> None:
        """Make the means under these lights, from as many directions as are traced; nothing when they are made.

        `broad`: how much [K] of each Gaussian a method sums with others before it knows V. That light's visibility
        follows V_K as nine means over parts of the surface frame (`reference.visibility.from_bands`); None: not at all.
        `above`: that is of the light from above the horizon alone (inputs/visibility/seen_around.glsl).
        """
        sharp = self._sharp is lights
        state = self.done, sharp, None if broad is None else broad.tobytes(), above
        if self._lights is lights and self._state == state:
            return
        tables = [self._table(c, lights, sharp) for c in range(self.classes)]
        first_broad = tables[0].shape[1] // 4
        self.groups = first_broad + (0 if broad is None else BROAD // 4)
        P, V = len(self.probes.points), self.probes.spread.shape[0]
        self._sums.reserve(32 * self.groups * P)
        self.means.reserve(8 * self.groups * V)
        entries, ranges = [], []
        begin = 0
        for directions, table in zip(self._traced, tables, strict=True):
            for group in range(first_broad):
                entries.append(_entries(directions[: len(table)], table[:, 4 * group : 4 * group + 4]))
                ranges.append((begin, begin + len(entries[-1])))
                begin = ranges[-1][1]
        self._entries.write(np.concatenate(entries))
        self._ranges.write(np.array(ranges, "i4"))
        for unit, buffer in enumerate((self._bits, self._entries, self._probe_data, self._ranges), 9):
            buffer.bind(unit)
        self._sums.buffer.bind_to_storage_buffer(0)
        self._run_classes(
            self._program("passes/visibility/mean.comp"), first_broad, group_count=self.groups, steepness=self.steepness
        )
        self.ctx.memory_barrier()
        sums = sum(table.sum(0) for table in tables)
        if broad is not None:
            there = self._sum_broad(lights, broad, first_broad, above)
            sums = np.append(sums, np.full(BROAD, BROAD_PART * there))
            sums[top_number(len(lights.gaussians))] = BROAD_PART * there
            self.ctx.memory_barrier()
        self._least.write(np.where(sums > 0.0, LEAST * sums, 1.0).astype("f4"))
        program = self._program("passes/visibility/spread.comp")
        for unit, buffer in enumerate((self._sums, self._row_data, self._spread_data, self._least), 9):
            buffer.bind(unit)
        self.means.buffer.bind_to_storage_buffer(0)
        shader.set_uniforms(program, last_item=V, group_count=self.groups)
        program.run(-(-V // 64), self.groups)
        self.ctx.memory_barrier()
        self._lights, self._state = lights, state
        self.version += 1

    def gather(self, program_of, radiance: TextureBuffer, sums: TextureBuffer, means: TextureBuffer) -> None:
        """Gather what the fixed directions met into `means`: the mean radiance that comes back to each vertex, front and
        back, and the mean of its luminance times its direction.

        Parameters
        ----------
        program_of : makes the program of a pass
        radiance : of all vertices in the numbering of `places`
        sums : for what is between
        """
        V = self.probes.spread.shape[0]
        sums.reserve(64 * len(self.probes.points))
        means.reserve(64 * V)
        program = program_of("bounce_gather")
        for unit, buffer in enumerate((self._hits, radiance, self._probe_data, self._direction_data), 9):
            buffer.bind(unit)
        sums.buffer.bind_to_storage_buffer(0)
        size = len(self._traced[0])
        self._run_classes(program, class_directions=size, direction_count=self.done, steepness=self.steepness)
        self.ctx.memory_barrier()
        program = program_of("bounce_spread")
        for unit, buffer in enumerate((sums, self._row_data, self._spread_data), 9):
            buffer.bind(unit)
        means.buffer.bind_to_storage_buffer(0)
        shader.set_uniforms(program, vertex_count=V)
        program.run(-(-V // 64))
        self.ctx.memory_barrier()

    def _sum_broad(self, lights: Lights, broad: np.ndarray, first_broad: int, above: bool) -> float:
        """Sum what the probes see of the broad light; returns how much of it there is, over the traced directions."""
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
        self._light_data.write(records)
        for unit, buffer in enumerate((self._bits, self._light_data, self._probe_data, self._x_data), 9):
            buffer.bind(unit)
        self._run_classes(
            self._program("passes/visibility/broad.comp"),
            group=first_broad,
            top_number=top_number(len(gaussians)),
            group_count=self.groups,
            share=self.share,
            direction_count=self.done,
        )
        return float(used.sum())  # a view: scaled, too

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

    def _run_classes(self, program, layers: int = 1, **uniforms) -> None:
        """Run a program for all probes of all classes, `layers` times."""
        first = self.probes.first
        padded = np.append(first, np.repeat(first[-1:], MOST_CLASSES + 1 - len(first)))
        shader.set_uniforms(program, first_probe=[int(n) for n in padded], probe_count=int(first[-1]), **uniforms)
        program.run(-(-int(np.diff(first).max()) // 64), self.classes, layers)

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
            self._ranges,
            self._least,
            self._direction_data,
            self._hits,
        )
        for thing in (*buffers, self._sums, self.means, self._queries, self._program):
            thing.release()


def top_number(gaussians: int) -> int:
    """The number of the broad light's mean at the top, after those of so many Gaussians."""
    return 1 + gaussians


def broad_number(gaussians: int) -> int:
    """The number of the first of the broad light's means in the bands."""
    return -(-(2 + gaussians) // 4) * 4


def sun_number(gaussians: int) -> int:
    """The number of the first sun."""
    return broad_number(gaussians) + BROAD


def _entries(directions: np.ndarray, table: np.ndarray) -> np.ndarray:
    """The directions that count for four columns of a table: [E, 8] float32, each with its number and what it weighs."""
    number = np.flatnonzero(table.any(1))
    entries = np.empty((len(number), 8), "f4")
    entries[:, :3], entries[:, 3], entries[:, 4:] = directions[number], number, table[number]
    return entries
