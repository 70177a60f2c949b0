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
from ..reference.visibility import LEAST, cube_shares, gaussian_table, own_directions, world_directions
from .probes import Probes, place_probes

DIRECTIONS = 256
WORD = 32
FEWEST = 16  # directions that must be traced before there is a mean
BROAD_LAYERS = 6
NARROW = 30.0  # sharpness from which a Gaussian has directions of its own,
OWN = 8  # so many
NEAREST_LAYER = 1 / 3  # of the way to the next layer of cloth: how far rays may start from their own


class VertexVisibility:
    """V_0 and V_k of the front and the back of every vertex of one mesh.

    `start` takes a mesh, `step` traces some directions (`done` says how many are), `sharpen` those that the narrow
    Gaussians of some lights have of their own, `integrate` makes the means under these lights, which then lie in `means`:
    of each vertex front and back, of each side `groups` words of four unorm8: V_0, V_1 .. V_K.
    """

    def __init__(self, ctx):
        self.ctx = ctx
        self.done = self.groups = self.layers = 0
        self.version = 0  # of the means: changes when they do
        self.probes: Probes | None = None
        self._programs: dict[str, object] = {}
        self._queries = RayQueries(ctx)
        self._probe_data = TextureBuffer(ctx, 32)
        self._between_data = TextureBuffer(ctx, 32, "rgba32ui")
        self._bits = TextureBuffer(ctx, 4, "r32ui")
        self._table = TextureBuffer(ctx, 16)
        self._probe_means = TextureBuffer(ctx, 4, "r32ui")
        self._vertex_means = TextureBuffer(ctx, 4, "r32ui")
        # As float32, so that the twin and the table see what the rays follow.
        self.directions = world_directions(DIRECTIONS).astype("f4").astype(float)
        self._direction_data = TextureBuffer(ctx, 16 * DIRECTIONS)
        self._structure = self._lights = self._sharp = None
        self._state = None

    def start(self, mesh: Mesh, structure, original: Mesh | None = None) -> None:
        """Forget what was seen and look out from another mesh.

        Parameters
        ----------
        structure : built, over the triangles that hide light (`glcloth.accel`)
        original : see `place_probes`
        """
        self.start_at(place_probes(mesh, original), structure)

    def start_at(self, probes: Probes, structure) -> None:
        """As `start`, from given probes."""
        self.probes, self._structure = probes, structure
        self.done, self._lights, self._sharp, self._state = 0, None, None, None
        count = len(probes.points)
        offset = self._offset_between_layers()
        records = np.zeros((count, 2, 4), "f4")
        records[:, 0, :3], records[:, 1, :3] = probes.points, probes.normals
        records[:, 0, 3], records[:, 1, 3] = offset.T
        self._probe_data.write(records)
        self._bits.write(np.zeros((DIRECTIONS // WORD, count), "u4"))
        self._write_directions(self.directions)
        self._spread = count < len(probes.between)
        if self._spread:
            between = np.concatenate([probes.between.astype("u4"), probes.weight.astype("f4").view("u4")], 1)
            self._between_data.write(between)

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

    @property
    def complete(self) -> bool:
        """True when all directions are traced."""
        return self.done == DIRECTIONS

    def _write_directions(self, directions: np.ndarray) -> None:
        self._traced = directions
        padded = np.zeros((len(directions), 4), "f4")
        padded[:, :3] = directions
        self._direction_data.write(padded)

    def step(self, count: int = WORD) -> int:
        """Trace at most `count` more directions, to the next multiple of 32 at most; returns how many."""
        first = self.done
        last = min(first + count, (first // WORD + 1) * WORD, DIRECTIONS)
        if last > first:
            self._trace(first, last)
            self.done = last
        return last - first

    def _trace(self, first: int, last: int) -> None:
        program = self._program("trace", {"accel.glsl": self._structure.source})
        self._structure.bind(program)
        self._probe_data.bind(11)
        self._direction_data.bind(12)
        self._bits.buffer.bind_to_storage_buffer(0)
        self._run(program, len(self.probes.points), first_direction=first, last_direction=last)

    def steps(self, lights: Lights | None = None, count: int = WORD) -> Iterator[int]:
        """What is left to trace, `count` directions at a time: the fixed ones, then those of the narrow Gaussians of
        `lights`. Yields after each step how many are traced."""
        while not self.complete:
            self.step(count)
            self.ctx.finish()  # so that progress tells the truth and Ctrl-C is heard
            yield self.done
        yield from self._sharpen(lights, count) if lights is not None else ()

    def _sharpen(self, lights: Lights, count: int) -> Iterator[int]:
        if self._sharp is lights:
            return
        gaussians = lights.gaussians
        narrow = np.flatnonzero(gaussians.sharpness >= NARROW)
        own = [own_directions(gaussians.axis[k], gaussians.sharpness[k], OWN) for k in narrow]
        self._sharp = None
        self._write_directions(np.concatenate([self.directions, *own]).astype("f4").astype(float))
        words = -(-len(self._traced) // WORD)
        self._grow_bits(words)
        first = DIRECTIONS
        while first < len(self._traced):
            last = min(first + count, (first // WORD + 1) * WORD, len(self._traced))
            self._trace(first, last)
            self.ctx.finish()
            first = last
            yield last
        self._sharp, self._narrow = lights, narrow

    def _grow_bits(self, words: int) -> None:
        """Make room for so many words of bits of every probe; keep what is traced."""
        size = 4 * words * len(self.probes.points)
        if size > self._bits.size:
            kept = self._bits.buffer.read()
            self._bits.reserve(size)
            self._bits.write(kept)

    def total(self, lights: Lights | None = None) -> int:
        """How many directions `steps` traces in all."""
        return DIRECTIONS + (OWN * int((lights.gaussians.sharpness >= NARROW).sum()) if lights is not None else 0)

    def integrate(self, lights: Lights, broad: np.ndarray | None = None) -> None:
        """Make the means under these lights, from as many directions as are traced; nothing when they are made.

        `broad`: how much [K] of each Gaussian a method sums with others before it knows V. That light's visibility
        follows V_K as six means, over the parts of the sphere that `cube_shares` tells.
        """
        sharp = self._sharp is lights
        state = self.done, sharp, None if broad is None else broad.tobytes()
        if self._lights is lights and self._state == state:
            return
        gaussians = lights.gaussians
        count = len(self.probes.points)
        table = gaussian_table(self.directions[: self.done], gaussians.axis, gaussians.sharpness)
        if sharp:
            own = np.zeros((len(self._traced), table.shape[1]))
            own[: self.done] = table
            own[:, 1 + self._narrow] = 0.0
            for place, k in enumerate(self._narrow):
                own[DIRECTIONS + OWN * place :][:OWN, 1 + k] = 1.0
            table = own
        if broad is not None:
            table = np.concatenate([table, self._cube_table(lights, broad, len(table))], 1)
        self.layers = table.shape[1]
        self.groups = -(-self.layers // 4)
        self._probe_means.reserve(8 * self.groups * count)
        first, entries = _entries(self._traced, table)
        self._table.write(entries)
        sums = np.ones(4 * self.groups + 4)
        sums[: table.shape[1]] = table.sum(0)
        program = self._program("mean")
        for unit, buffer in enumerate((self._bits, self._table, self._probe_data), 9):
            buffer.bind(unit)
        self._probe_means.buffer.bind_to_storage_buffer(0)
        for group in range(self.groups):
            members = slice(4 * group, 4 * group + 4)
            self._run(
                program, count, group=group, group_count=self.groups, first=tuple(first[members]),
                last=tuple(first[4 * group + 1 : 4 * group + 5]), least=tuple(LEAST * sums[members]),
            )  # fmt: skip
        if self._spread:
            vertices = len(self.probes.between)
            self._vertex_means.reserve(8 * self.groups * vertices)
            self._probe_means.bind(9)
            self._between_data.bind(10)
            self._vertex_means.buffer.bind_to_storage_buffer(0)
            self._run(self._program("spread"), vertices, words=2 * self.groups)
        self._lights, self._state = lights, state
        self.version += 1

    def _cube_table(self, lights: Lights, broad: np.ndarray, rows: int) -> np.ndarray:
        """Weights [rows, 6] of the directions in the six means."""
        directions, gaussians = self.directions[: self.done], lights.gaussians
        light = SphericalGaussians(gaussians.axis, gaussians.sharpness, gaussians.amplitude * broad[:, None])
        weight = luminance(np.maximum(light.radiance(directions), 0.0))
        # Where there is no such light, V still goes on smoothly from where there is.
        weight = weight / max(weight.mean(), 1e-30) + 0.02
        out = np.zeros((rows, 6))
        out[: self.done] = weight[:, None] * cube_shares(directions)
        return out / out.max()

    @property
    def means(self) -> TextureBuffer:
        """The means of the vertices, as passes/visibility_pixels.comp reads them."""
        return self._vertex_means if self._spread else self._probe_means

    def bits(self) -> np.ndarray:
        """Read back what the probes see: bool [P, done]."""
        count = len(self.probes.points)
        words = np.frombuffer(self._bits.buffer.read(4 * count * (DIRECTIONS // WORD)), "<u4").reshape(-1, count)
        return np.unpackbits(words.T.copy().view("u1"), axis=1, bitorder="little")[:, : self.done].astype(bool)

    def values(self) -> np.ndarray:
        """Read back the means: float [V, 2, 1 + K], or [V, 2, 7 + K] with `broad`."""
        vertices = len(self.probes.between)
        data = np.frombuffer(self.means.buffer.read(8 * self.groups * vertices), "u1")
        return data.reshape(vertices, 2, -1)[..., : self.layers] / 255.0

    def _program(self, stage: str, virtual: dict | None = None):
        if stage not in self._programs:
            virtual = {"count.glsl": "passes/count_none.glsl", **(virtual or {})}
            self._programs[stage] = shader.compute(self.ctx, f"passes/visibility_{stage}.comp", None, virtual)
        return self._programs[stage]

    def _run(self, program, count: int, **uniforms) -> None:
        shader.set_uniforms(program, probe_count=count, vertex_count=count, **uniforms)
        program.run(-(-count // 64))
        self.ctx.memory_barrier()

    def release(self) -> None:
        """Free the GPU's memory."""
        buffers = (self._probe_data, self._between_data, self._bits, self._table, self._direction_data)
        means = (self._probe_means, self._vertex_means)
        for thing in (*buffers, *means, self._queries, *self._programs.values()):
            thing.release()


def _entries(directions: np.ndarray, table: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Per column of a table the directions that count: where those of a column begin [>= columns + 1], and for each the
    direction and its number + G / 2, [E, 4] float32. Columns beyond the table's have none."""
    column, number = np.nonzero(table.T)
    entries = np.empty((len(column), 4), "f4")
    entries[:, :3] = directions[number]
    entries[:, 3] = number + 0.5 * table[number, column]
    first = np.searchsorted(column, np.arange(table.shape[1] + 5))
    return first.astype(int), entries
