"""What the pixels of a G-buffer see of the lights, for the passes that shade them.   [own, docs/shadows.md]"""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass

import moderngl
import numpy as np

from ..fabric import Fabric
from ..geometry.mesh import Mesh
from ..gpu import shader
from ..gpu.buffers import TextureBuffer
from ..gpu.gbuffer import GBuffer
from ..gpu.scene_buffers import SceneBuffers
from ..light.lights import Lights
from ..settings import Shadows as Mode
from ..twins.visibility import own_directions
from .vertices import FEWEST, FLAT, NARROW, VertexVisibility, broad_number, sun_number, top_number

SEEN_UNIT = 2
SEEN_ALL, SEEN_PIXELS = "inputs/visibility/seen_all.glsl", "inputs/visibility/seen_pixels.glsl"
SEEN_AROUND = "inputs/visibility/seen_around.glsl"
TILE = 8
FURNACE_VIEWS, FURNACE_LIGHTS = 64, 256
MOVING_CLASSES = 8  # of probes on cloth that moves: each traces a quarter of its 32 directions at every pose
EDGE_RAYS = 16  # of a pixel into a narrow Gaussian, of all its samples together,
FEWEST_EDGE_RAYS = 4  # and of each
FEWEST_TILES = 32  # of 8 x 8 pixels, at a time
PATIENCE = 0.1  # seconds of rays from pixels between two looks at Ctrl-C
CUT = 2.0  # mean edges by which the vertices may move in the mean from pose to pose


@dataclass(frozen=True, eq=False)
class Beside:
    """What hides light beside a mesh.

    Parameters
    ----------
    meshes : the others, but for a ground
    ground : whether there is one
    places : in which all that rays meet is numbered
    """

    meshes: tuple[Mesh, ...]
    ground: bool
    places: object


class Shadows:
    """Keeps what the vertices of one mesh see, and brings it to the pixels, and the rays of the suns with it."""

    def __init__(self, ctx: moderngl.Context, steepness: float = FLAT):
        """`steepness`: see `VertexVisibility`."""
        self.ctx = ctx
        self.vertices = VertexVisibility(ctx, steepness)
        self._program = shader.Computes(ctx)
        self._sun_data = TextureBuffer(ctx, 16)
        self._meshes: tuple[Mesh, ...] = ()  # that was looked out from, and the others that hide light
        self.follow = self.over_ground = False
        self._beside: Beside | None = None
        self._structure = self._lights = None
        self._mode: Mode = "off"
        self._sample = 0, 1
        self._edge_data = TextureBuffer(ctx, 16)
        self._filled: dict[GBuffer, tuple] = {}
        self._looked: dict[GBuffer, int] = {}  # up to which tile narrow Gaussians were looked into from its pixels
        self._furnace: tuple | None = None  # fabric, its albedo
        self._points: tuple | None = None

    def follow_poses(self, follow: bool) -> None:
        """Take the next mesh with the same triangles for the next pose, or not."""
        if follow != self.follow:
            self.follow, self._meshes = follow, ()

    # -- what is seen ------------------------------------------------------------------------------------------------

    def prepare(
        self,
        mode: Mode,
        mesh: Mesh,
        original: Mesh,
        structure,
        lights: Lights,
        bounce: bool = True,
        beside: Beside | None = None,
    ) -> None:
        """Choose what hides what. `mesh` is the one that is drawn, `original` what it was subdivided from, `structure`
        what hides light: the mesh and what is `beside` it."""
        self._mode, self._structure, self._lights, self._bounce = mode, structure, lights, bounce
        self._others = () if beside is None else beside.meshes
        self._beside = beside
        self.over_ground = beside is not None and beside.ground
        self.vertices.places = None if beside is None else beside.places
        meshes = mesh, *self._others
        if mode == "full" and not _same(self._meshes, meshes):
            if self.follow and is_next_pose(self._meshes, meshes):
                self.vertices.move(mesh, structure)
            else:  # a cut fills at once
                classes = MOVING_CLASSES if self.follow else None
                self.vertices.start(mesh, structure, original, classes)
            self._meshes = meshes

    def steps(self, count: int = 32, enough: int | None = None) -> Iterator[int]:
        """Trace what the vertices still lack, so many directions at a time; or only until there are `enough` of them."""
        if self._mode == "full" and enough is not None:
            while self.vertices.done < enough:
                self.vertices.step(count)
                self.ctx.finish()
                yield self.vertices.done
        elif self._mode == "full":
            # Directions of narrow Gaussians would all have to be traced at every pose.
            yield from self.vertices.steps(None if self.follow else self._lights, count)

    def total(self) -> int:
        """How many steps of 32 directions there are in all, about."""
        return -(-self.vertices.total(None if self.follow else self._lights) // 32) if self._mode == "full" else 0

    def hurry(self) -> None:
        """Trace only as much as a first impression needs."""
        if self._mode == "full":
            while self.vertices.done < FEWEST:
                self.vertices.step(FEWEST)

    def integrate(self, method) -> None:
        """Make the means of the vertices under the present lights; nothing when they are made. `method` None: of each
        light alone, as a Lambertian needs them."""
        if self._mode == "full":
            none = np.zeros(len(self._lights.gaussians))
            broad = None if method is None else getattr(method, "broad", none)
            self.vertices.integrate(self._lights, broad, self.over_ground)

    def look(self, buffer: GBuffer, method, sample: tuple[int, int] = (0, 1)) -> None:
        """Fill the layers of what the pixels of a G-buffer see, as it is drawn now; nothing when they hold just that.

        `sample` is the number of the sample in the pixel, and how many there are: `edges` shares its rays among them.
        """
        self._sample = sample
        lights = self._lights
        full = self._mode == "full"
        count = len(lights.gaussians)
        first = broad_number(count)
        self._numbers = {
            "top_number": top_number(count),
            "broad_number": first,
            "sun_number": first if method is None else sun_number(count),
        }
        sun_layer = self._numbers["sun_number"] // 4
        self.integrate(method)
        seen = buffer.reserve_seen(sun_layer + -(-len(lights.suns) // 4))
        self._seen = seen
        version = self.vertices.version if full else 0
        state = buffer.drawn, sample, self._mode, self._structure, self._others, seen, version
        before = self._filled.get(buffer)
        # Lights have no truth value for ==; they are frozen, so the same object is the same light.
        if before is not None and before[0] is lights and before[1] == state:
            return
        kept = {key: value for key, value in self._filled.items() if key.seen is not None}
        self._filled = kept | {buffer: (lights, state)}
        self._looked = {key: rows for key, rows in self._looked.items() if key in kept and key is not buffer}
        mesh = buffer.drawn[0]
        buffer.bind_points(None)
        seen.bind_to_image(0, read=False, write=True)
        program = self._program("passes/visibility/pixels.comp")
        buffer.bind(program)
        if full:
            self.vertices.means.bind(9)
        mesh.indices.bind(10)
        self._run(program, buffer, group_count=sun_layer, everything=not full)
        suns = lights.suns
        if len(suns):
            directions = np.zeros((len(suns), 4), "f4")
            directions[:, :3] = suns.direction
            self._sun_data.write(directions)
            program = self._program("passes/visibility/suns.comp", {"accel.glsl": self._structure.source})
            self._structure.bind(program)
            self._sun_data.bind(10)
            buffer.bind(program)
            buffer.bind_points(program)
            self._run(program, buffer, sun_count=len(suns), first_layer=sun_layer)
        self.ctx.memory_barrier()

    def edges(self, buffer: GBuffer, seconds: float = PATIENCE) -> Iterator[int]:
        """Look into the narrow Gaussians again, from those pixels of a G-buffer that was looked at whose triangles' corners
        do not agree on what they see of them. Does nothing where that is done, or poses are followed.

        Parameters
        ----------
        seconds : of work, about, between two yields

        Yields how many tiles of the picture are done.
        """
        narrow = np.flatnonzero(self._lights.gaussians.sharpness >= NARROW)
        width, height = (-(-side // TILE) for side in buffer.size)
        first = self._looked.get(buffer, 0)
        if self._mode != "full" or self.follow or not len(narrow) or first >= width * height:
            return
        program = self._program("passes/visibility/narrow.comp", {"accel.glsl": self._structure.source})
        fours = self._upload_edges(narrow, self._sample)
        count = FEWEST_TILES
        while first < width * height:
            begin = time.perf_counter()
            count = min(count, width * height - first)
            self._structure.bind(program)
            self._seen.bind_to_image(0, read=True, write=True)
            buffer.bind(program)
            buffer.drawn[0].indices.bind(10)
            self._edge_data.bind(11)
            self.vertices.means.bind(12)
            shader.set_uniforms(program, group_count=self.vertices.groups, first_tile=first, row_tiles=width)
            for layer, begins, rays in fours:
                shader.set_uniforms(program, layer=layer, begin=begins, direction_count=rays)
                program.run(count)
            self.ctx.memory_barrier()
            self.ctx.finish()
            first += count
            self._looked[buffer] = first
            faster = seconds / max(time.perf_counter() - begin, 1e-4)
            count = max(FEWEST_TILES, int(count * min(max(faster, 0.25), 4.0)))
            yield first

    def forget_edges(self, buffer: GBuffer) -> None:
        """Let the pixels of a G-buffer look into the narrow Gaussians anew."""
        self._looked.pop(buffer, None)

    def _upload_edges(self, narrow: np.ndarray, sample: tuple[int, int]) -> list[tuple]:
        """Upload the directions of rays from pixels; returns each texel of four numbers that has narrow Gaussians, where
        their directions begin (-1: none) and how many each has."""
        gaussians = self._lights.gaussians
        number, samples = sample
        total = max(EDGE_RAYS // samples, FEWEST_EDGE_RAYS) * samples
        # From the outside in, as the pass wants it.
        own = np.stack([own_directions(gaussians.axis[k], gaussians.sharpness[k], total)[::-1] for k in narrow])
        own = own[:, number::samples]
        directions = np.zeros((own.shape[0] * own.shape[1], 4), "f4")
        directions[:, :3] = own.reshape(-1, 3)
        self._edge_data.write(directions)
        begins = np.full(4 * self._seen.layers, -1)
        begins[1 + narrow] = own.shape[1] * np.arange(len(narrow))
        begins = begins.reshape(-1, 4)
        return [(n, tuple(map(int, four)), own.shape[1]) for n, four in enumerate(begins) if (four >= 0).any()]

    @property
    def source(self) -> str:
        """What "seen.glsl" means to a program that asks for these shadows."""
        return SEEN_PIXELS if self._beside is None or self._mode != "full" else SEEN_AROUND

    def bind_seen(self, program) -> None:
        """Bind the values of the G-buffer that was looked at last, for a program with `sampler2DArray seen`."""
        self._seen.use(SEEN_UNIT)
        shader.set_uniforms(program, over_ground=self.over_ground, **self._numbers)

    def bind(self, program, fabric: Fabric, shared: SceneBuffers) -> None:
        """Bind what inputs/visibility/seen_pixels.glsl reads of the G-buffer that was looked at last."""
        albedo = self.albedo(fabric, shared) if self._mode == "full" and self._bounce else np.zeros(3)
        self.bind_seen(program)
        shader.set_uniforms(program, albedo=tuple(map(float, albedo)))

    # -- how much a fabric reflects ----------------------------------------------------------------------------------

    def albedo(self, fabric: Fabric, shared: SceneBuffers) -> np.ndarray:
        """What [3] a fabric reflects of light that comes evenly from everywhere, in the mean over all views by their
        cosine; `shared` holds the fabric. From 64 x 256 directions, kept until the fabric changes."""
        if self._furnace is None or self._furnace[0] is not fabric:
            program = self._program("passes/methods/furnace.comp")
            if self._points is None:
                data = np.zeros((FURNACE_VIEWS + FURNACE_LIGHTS, 4), "f4")
                data[:FURNACE_VIEWS, :3] = _cosine_directions(FURNACE_VIEWS)
                data[FURNACE_VIEWS:, :3] = even_directions(FURNACE_LIGHTS)
                result = self.ctx.buffer(reserve=16 * FURNACE_VIEWS)
                self._points = TextureBuffer(self.ctx, data), result
            shared.bind(program)
            self._points[0].bind(9)
            self._points[1].bind_to_storage_buffer(0)
            shader.set_uniforms(program, view_count=FURNACE_VIEWS, light_count=FURNACE_LIGHTS)
            program.run(-(-FURNACE_VIEWS // 64))
            self.ctx.memory_barrier()
            radiance = np.frombuffer(self._points[1].read(), "f4").reshape(-1, 4)[:, :3]
            self._furnace = fabric, np.clip(radiance.mean(0), 0.0, 1.0)
        return self._furnace[1]

    # -- the machinery -----------------------------------------------------------------------------------------------

    def _run(self, program, buffer: GBuffer, **uniforms) -> None:
        shader.set_uniforms(program, **uniforms)
        program.run(-(-buffer.size[0] // TILE), -(-buffer.size[1] // TILE))


def _same(before: tuple[Mesh, ...], meshes: tuple[Mesh, ...]) -> bool:
    """Whether two lists are of the same meshes."""
    return len(before) == len(meshes) and all(a is b for a, b in zip(before, meshes, strict=True))


def is_next_pose(before: tuple[Mesh, ...], meshes: tuple[Mesh, ...]) -> bool:
    """Whether meshes are the ones before, moved a little."""
    return len(before) == len(meshes) and all(map(_moved_a_little, before, meshes))


def _moved_a_little(before: Mesh, mesh: Mesh) -> bool:
    if before is mesh:
        return True
    if before.triangles.shape != mesh.triangles.shape or before.positions.shape != mesh.positions.shape:
        return False
    if before.triangles is not mesh.triangles and not np.array_equal(before.triangles, mesh.triangles):
        return False
    a, b = mesh.positions[mesh.triangles[:, 0]], mesh.positions[mesh.triangles[:, 1]]
    edge = np.linalg.norm(a - b, axis=1).mean()
    return bool(np.linalg.norm(mesh.positions - before.positions, axis=1).mean() < CUT * edge)


def even_directions(count: int) -> np.ndarray:
    """Directions [count, 3] over the upper hemisphere, even in solid angle."""
    n = np.arange(count) + 0.5
    z, phi = 1.0 - n / count, np.pi * (3.0 - np.sqrt(5.0)) * n
    r = np.sqrt(1.0 - z * z)
    return np.stack([r * np.cos(phi), r * np.sin(phi), z], -1)


def _cosine_directions(count: int) -> np.ndarray:
    """Directions [count, 3] over the upper hemisphere, even in cosine-weighted solid angle."""
    n = np.arange(count) + 0.5
    r, phi = np.sqrt(n / count), np.pi * (3.0 - np.sqrt(5.0)) * n
    return np.stack([r * np.cos(phi), r * np.sin(phi), np.sqrt(1.0 - r * r)], -1)
