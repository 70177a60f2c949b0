"""The ray tracer of paper B: rays, their hits and their shadows in queues, generation by generation.   [Mat section 4.2]

One generation at a time is cast, shaded and shadowed: camera rays, then the rays they cause behind and before the cloth,
to the depth asked for. Light through cloth goes straight on, so one traversal of the kd-tree finds all layers along a
way at once, and only the heads of ways are cast: camera rays and mirrored ones. Each ray's radiance is kept, and at the
end children are added to their parents, so that no sum depends on the order in which the GPU works. Large pictures are
made in tiles.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import moderngl
import numpy as np

from ..accel.queries import RayQueries, cast
from ..accel.structure import Structure, make_structure
from ..accel.triangles import PADDING, Triangles
from ..errors import InputError
from ..fabric import Fabric
from ..geometry.camera import Camera
from ..gpu import shader
from ..gpu.buffers import TextureBuffer
from ..gpu.layout import shared
from ..gpu.scene_buffers import SceneBuffers
from ..light.environment import Environment, rotation_y
from ..progress import track
from .energy import mean_albedo, reflection_limit
from .lamp import Lighting
from .layers import LayersPicture

DEEPEST = 8
TILE_PIXELS = 1 << 17  # rays of the first generation at a time; each causes up to 2^(depth - 1) more
ENVIRONMENT_UNIT = 6
CONSTANTS, _ = shared("trace/shared.glsl")
RAYS_UNIT = 11
BLOCK = CONSTANTS["BLOCK_WIDTH"], CONSTANTS["BLOCK_HEIGHT"]


@dataclass(frozen=True)
class TraceSettings:
    """How a picture is traced.

    depth : generations of rays, 1 to 8 (the paper's level 4). spp : samples per pixel. spread : draw transmitted
    directions from the fabric's lobes, so that what is seen through the yarns blurs (needs many samples) instead of going
    straight on. cutoff : rays that count for less are not followed. accelerator : kdtree, lbvh or brute.
    """

    depth: int = 4
    spp: int = 1
    spread: bool = False
    cutoff: float = 1e-3
    accelerator: str = "kdtree"

    def __post_init__(self):
        if not 1 <= self.depth <= DEEPEST:
            raise InputError(f"depth = {self.depth}, expected 1 to {DEEPEST} generations of rays")
        if not 1 <= self.spp <= 4096:
            raise InputError(f"spp = {self.spp}, expected 1 to 4096 samples per pixel")
        if not 0 <= self.cutoff < 1:
            raise InputError(f"cutoff = {self.cutoff}, expected 0 or more and less than 1")


@dataclass(frozen=True)
class Shot:
    """What a picture shows of a scene, and how.

    size : width, height in pixels. environment : seen by rays that leave the scene, turned by `env_rotate` degrees.
    offsets : where in the pixel the samples lie, from its centre; default: the R2 sequence of `settings.spp` points.
    """

    camera: Camera
    size: tuple[int, int]
    fabric: Fabric
    lighting: Lighting = field(default_factory=Lighting)
    environment: Environment | None = None
    settings: TraceSettings = TraceSettings()
    env_rotate: float = 0.0
    offsets: tuple[tuple[float, float], ...] | None = None

    def __post_init__(self):
        if self.fabric.transmission is None:
            raise InputError(
                f"fabric {self.fabric.name}: has no [transmission], which the ray tracer needs; add the block, or take "
                "sheer_voile"
            )

    @property
    def samples(self) -> Sequence[tuple[float, float]]:
        """Where in the pixel the samples lie."""
        return self.offsets or sample_offsets(self.settings.spp)


@dataclass
class TraceStatistics:
    """What the last picture took: rays and shadow rays per generation, how many rays were heads of a straight way and so
    were cast, ms of each stage per generation (`build` by the structure's stages), ms in all."""

    rays: list[int] = field(default_factory=list)
    heads: list[int] = field(default_factory=list)
    shadow_rays: list[int] = field(default_factory=list)
    trace_ms: list[float] = field(default_factory=list)
    shade_ms: list[float] = field(default_factory=list)
    shadow_ms: list[float] = field(default_factory=list)
    gather_ms: float = 0.0
    build_ms: dict[str, float] = field(default_factory=dict)
    total_ms: float = 0.0

    def add(
        self, level: int, rays: int, heads: int, shadow_rays: int, trace: float, shade: float, shadow: float
    ) -> None:
        """Add one generation of one tile."""
        while len(self.rays) <= level:
            for column in (self.rays, self.heads, self.shadow_rays, self.trace_ms, self.shade_ms, self.shadow_ms):
                column.append(0)
        self.rays[level] += rays
        self.heads[level] += heads
        self.shadow_rays[level] += shadow_rays
        self.trace_ms[level] += trace
        self.shade_ms[level] += shade
        self.shadow_ms[level] += shadow


class _Generation:
    """The queues of one generation of rays."""

    def __init__(self, ctx):
        self.weights = TextureBuffer(ctx, 64)
        self.radiance = TextureBuffer(ctx, 64)
        self.children = TextureBuffer(ctx, 64, "rg32ui")
        self.front = self.back = self.capacity = 0

    def reserve(self, capacity: int) -> None:
        """Make room for so many rays."""
        self.capacity = capacity
        for buffer in (self.weights, self.radiance, self.children):
            buffer.reserve(capacity * buffer.texel_bytes)

    @property
    def count(self) -> int:
        return self.front + self.back

    @property
    def runs(self) -> dict[str, int]:
        """Where the rays lie: `front` of them at the front, the others at the very end."""
        return {"ray_count": self.count, "front_count": self.front, "back_first": self.capacity - self.back}

    def release(self) -> None:
        for buffer in (self.weights, self.radiance, self.children):
            buffer.release()


class Tracer:
    """Traces triangles of cloth and of a room on one OpenGL context.

    `render` does everything for arrays; a moving cloth uses `set_scene`, `build` and `trace` each frame.
    """

    def __init__(self, ctx: moderngl.Context):
        self.ctx = ctx
        self.queries = RayQueries(ctx)
        self.statistics = TraceStatistics()
        self._programs: dict[tuple, object] = {}
        self._structures: dict[str, object] = {}
        self._generations = [_Generation(ctx) for _ in range(DEEPEST + 1)]
        self._heads = TextureBuffer(ctx, 64)
        self._head_count = 0
        self._layers_hit = TextureBuffer(ctx, 64, "rgba32ui")
        self._shadows = TextureBuffer(ctx, 64)
        self._order = TextureBuffer(ctx, 64, "r32ui")
        self._counts = ctx.buffer(reserve=32, dynamic=True)
        self.picture = ctx.buffer(reserve=64, dynamic=True)
        self._work = ctx.buffer(reserve=64, dynamic=True)
        self._materials = TextureBuffer(ctx, 64)
        self._fabric = SceneBuffers(ctx)
        self._environment: tuple[Environment | None, moderngl.Texture | None] = (None, None)
        self.triangles: Triangles | None = None
        self._layers: LayersPicture | None = None

    # -- the scene -----------------------------------------------------------------------------------------------

    def set_scene(self, triangles: Triangles, materials: np.ndarray) -> None:
        """Trace these triangles from now on.

        materials : [M, 3] diffuse reflectances, linear Rec. 709; material 0 is the cloth, its reflectance is ignored
        """
        self.triangles = triangles
        records = np.zeros((len(materials), 4), np.float32)
        records[:, :3] = materials
        records[0, 3] = 1.0
        self._materials.write(records)

    def structure(self, name: str) -> Structure:
        """The acceleration structure of a name, made at first use. Raises InputError for an unknown one."""
        if name not in self._structures:
            self._structures[name] = make_structure(self.ctx, name)
        return self._structures[name]

    def build(self, accelerator: str = "kdtree") -> None:
        """Build the structure of the triangles as they are now."""
        self.structure(accelerator).build(self.triangles)

    def build_steps(self, accelerator: str = "kdtree") -> Iterator[None]:
        """As `build`, in steps where the structure has some, for a caller with other things to do in between."""
        structure = self.structure(accelerator)
        yield from structure.build_steps(self.triangles)

    def render(
        self,
        positions: np.ndarray,
        material: np.ndarray,
        materials: np.ndarray,
        shot: Shot,
        normals: np.ndarray | None = None,
        tangents: np.ndarray | None = None,
    ) -> np.ndarray:
        """Trace one picture of arrays.

        Parameters
        ----------
        positions : [T, 3, 3] metres; normals, tangents : [T, 3, 3] of the corners (default: flat; the first edge)
        material : [T] int, 0 is the cloth; materials : [M, 3] diffuse reflectances, linear Rec. 709

        Returns float32 [H, W, 3], linear Rec. 709, top row first. Raises InputError for wrong input.
        """
        positions = np.asarray(positions, np.float32).reshape(-1, 3, 3)
        scale = float(np.abs(positions).max(initial=1e-3))
        triangles = Triangles(self.ctx, len(positions), max(scale, float(np.abs(shot.camera.eye).max())))
        triangles.set(0, positions, normals, tangents, material)
        try:
            self.set_scene(triangles, materials)
            self.build(shot.settings.accelerator)
            return self.trace(shot)
        finally:
            triangles.release()
            self.triangles = None

    # -- tracing -------------------------------------------------------------------------------------------------

    def trace(self, shot: Shot) -> np.ndarray:
        """Trace one picture of the scene that was set and built; result as for `render`."""
        width, height = shot.size
        begin = time.perf_counter()
        steps = self.steps(shot)
        total = len(list(_tiles(width, height))) * len(shot.samples)
        for _ in track(steps, "trace: samples of tiles", total) if total > 1 else steps:
            pass
        picture = np.frombuffer(self.picture.read(16 * width * height), np.float32).reshape(height, width, 4)
        self.statistics.total_ms = 1000 * (time.perf_counter() - begin)
        return picture[..., :3].copy()

    def steps(self, shot: Shot, pixels: Callable[[], int] | None = None) -> Iterator[float]:
        """Trace one picture tile by tile into the buffer `picture`, for a caller with other things to do in between.
        The result does not depend on the tiles.

        pixels : called before each row of tiles: about how many pixels each of them shall have; default: TILE_PIXELS

        Yields the share that is done. `picture` holds a vec4 a pixel, top row first: linear Rec. 709, already divided by
        the number of samples, and how many samples have been added.
        """
        width, height = shot.size
        structure = self.structure(shot.settings.accelerator)
        self.statistics = TraceStatistics(build_ms=dict(structure.timings))
        begin = time.perf_counter()
        self._prepare(shot)
        self._reserve_picture(width * height)
        done = 0
        for k in range(len(shot.samples)):
            for tile in _tiles(width, height, pixels):
                self._trace_tile(tile, shot, k, structure)
                self.statistics.total_ms += 1000 * (time.perf_counter() - begin)
                (x, y), (across, rows) = tile
                done += min(BLOCK[0] * across, width - x) * min(BLOCK[1] * rows, height - y)
                yield done / (width * height * len(shot.samples))
                begin = time.perf_counter()

    def _prepare(self, shot: Shot) -> None:
        """Upload what changed and set the uniforms that hold for the whole picture."""
        fabric, lighting, environment, camera = shot.fabric, shot.lighting, shot.environment, shot.camera
        self._fabric.prepare(fabric)
        if environment is not self._environment[0]:
            if self._environment[1] is not None:
                self._environment[1].release()
            self._environment = environment, None if environment is None else _texture(self.ctx, environment)
        scale = self.triangles.padding / PADDING
        far = 4.0 * (scale + float(np.abs(camera.eye).max())) * 3**0.5
        shader.set_uniforms(self._program("camera"), eye=camera.eye, far=far)
        for shade in self._shades(shot.settings):
            self._set_light(shade, fabric, lighting, far)
            shader.set_uniforms(
                shade, offset=8 * self.triangles.padding, cutoff=shot.settings.cutoff, background=lighting.background,
                has_environment=environment is not None,
            )  # fmt: skip
            if "environment_from_world" in shade:
                shade["environment_from_world"].write(rotation_y(-shot.env_rotate).T.astype("f4").tobytes())
        shadow = self._program("shadow", self.structure(shot.settings.accelerator))
        _set_transmission(shadow, fabric)
        # From any point of the scene, both ends of which lie within `scale` of the middle along each axis, this is outside.
        shader.set_uniforms(
            shadow, lamp=lighting.lamp.vector, beyond=2 * 3**0.5 * scale, offset=8 * self.triangles.padding
        )

    def _set_light(self, program, fabric: Fabric, lighting: Lighting, far: float) -> None:
        """The uniforms of inputs/tracing/local_light.glsl."""
        limit = reflection_limit(fabric)
        _set_transmission(program, fabric)
        shader.set_uniforms(
            program, lamp=lighting.lamp.vector, intensity=lighting.lamp.intensity, ambient=lighting.ambient, far=far,
            cloth_albedo=tuple(map(float, mean_albedo(fabric) * limit)), reflection_limit=limit,
        )  # fmt: skip

    def layers(self, shot: Shot) -> np.ndarray:
        """Rasterise the scene that was set instead: sorted layers, blended, without shadows, before the lighting's
        background; result as for `trace`."""
        if self._layers is None:
            self._layers = LayersPicture(self.ctx)
        program = self._layers.program
        self._fabric.prepare(shot.fabric)
        self._set_light(program, shot.fabric, shot.lighting, 1e6)
        self._fabric.bind(program)
        self._bind_surfaces()
        return self._layers.draw(
            self.triangles.positions(),
            self.triangles.materials() == 0,
            shot.camera,
            shot.size,
            shot.lighting.background,
        )

    def _reserve_picture(self, pixels: int) -> None:
        if self.picture.size < 16 * pixels:
            self.picture.orphan(16 * pixels)
        self.picture.write(bytes(16 * pixels))

    def _trace_tile(self, tile, shot: Shot, sample: int, structure) -> None:
        """Add one sample of each pixel of a tile to the picture."""
        (x, y), blocks = tile
        size, settings = shot.size, shot.settings
        rays = 8 * blocks[0] * blocks[1]
        first = self._generations[0]
        first.reserve(rays)
        first.front, first.back = rays, 0
        # All layers of a way at once, where the structure finds hits in order and no ray turns aside in the cloth.
        layered = structure.ordered_hits and not settings.spread
        stride = settings.depth if layered else 1
        self._heads.extend(32 * rays)
        self._head_count = rays
        self._counts.write(np.array([0, 0, 0, rays], np.uint32).tobytes())
        where = {"size": size, "tile_first": (x, y), "tile_blocks": blocks}
        camera_pass = self._program("camera")
        shader.set_uniforms(camera_pass, jitter=shot.samples[sample], stride=stride, **where)
        camera_pass["ray_from_pixel"].write(shot.camera.ray_from_pixel(size).T.astype("f4").tobytes())
        self._heads.buffer.bind_to_storage_buffer(1)
        first.weights.buffer.bind_to_storage_buffer(2)
        self._run("camera", rays)

        last, cast = 0, 0
        for level in range(settings.depth):
            if self._generations[level].count == 0:
                break
            last = level
            cast = self._trace_generation(level, sample, structure, settings, stride, cast)

        begin = time.perf_counter()
        for level in range(last - 1, -1, -1):
            parent, child = self._generations[level], self._generations[level + 1]
            if child.count == 0:
                continue
            child.radiance.bind(8)
            parent.children.bind(9)
            parent.radiance.buffer.bind_to_storage_buffer(3)
            self._run("gather", parent.count, **parent.runs)
        first.radiance.bind(8)
        self.picture.bind_to_storage_buffer(0)
        self._run("picture", rays, share=1.0 / len(shot.samples), **where)
        self.statistics.gather_ms += 1000 * (time.perf_counter() - begin)

    def _trace_generation(
        self, level: int, sample: int, structure, settings: TraceSettings, stride: int, cast: int
    ) -> int:
        """Cast, shade and shadow one generation, and make the next; `cast` heads, and now the returned, have been cast."""
        now, then = self._generations[level], self._generations[level + 1]
        clock = [time.perf_counter()]
        heads = self._head_count - cast
        if heads:
            self._cast(structure, cast, heads, stride, settings.depth - level)
        clock.append(time.perf_counter())

        self._shadows.reserve(32 * now.count)
        then.reserve(max(2 * now.count, 1) if level + 1 < settings.depth else 1)
        self._heads.extend(32 * (self._head_count + 2 * now.count))
        self._counts.write(bytes(12))
        self._counts.write(bytes(8), offset=16)
        self._counts.bind_to_storage_buffer(5)
        self._bind_surfaces()
        self._layers_hit.bind(8)
        self._heads.bind(RAYS_UNIT)
        now.weights.bind(15)
        self._order.reserve(4 * now.count)
        self._order.buffer.bind_to_storage_buffer(0)
        self._run("sort", -(-now.count // CONSTANTS["PART_SHARE"]), **now.runs)
        on_cloth, others = (int(n) for n in np.frombuffer(self._counts.read(8, offset=16), np.uint32))
        self._order.bind(9)
        if self._environment[1] is not None:
            self._environment[1].use(ENVIRONMENT_UNIT)
        for binding, buffer in enumerate((self._heads, then.weights, now.radiance, now.children), 1):
            buffer.buffer.bind_to_storage_buffer(binding)
        self._shadows.buffer.bind_to_storage_buffer(6)
        runs = (on_cloth, 0), (others, on_cloth)
        for shade, (count, first) in zip(self._shades(settings), runs, strict=True):
            if count:
                self._fabric.bind(shade)
                shader.set_uniforms(
                    shade, ray_count=count, order_first=first, next_last=then.capacity - 1, level=level,
                    last_level=settings.depth - 1, generation_seed=sample * DEEPEST + level, stride=stride,
                    layered=stride > 1,
                )  # fmt: skip
                self._dispatch(shade, count)
        cast = self._head_count
        counts = np.frombuffer(self._counts.read(16), np.uint32)
        then.front, then.back, shadows, self._head_count = (int(n) for n in counts)
        clock.append(time.perf_counter())

        if shadows:
            program = self._program("shadow", structure)
            structure.bind(program)
            self._bind_surfaces()
            self._shadows.bind(RAYS_UNIT)
            self._shadows.buffer.bind_to_storage_buffer(6)
            now.radiance.buffer.bind_to_storage_buffer(3)
            chunks = list(structure.chunks())
            for k, uniforms in enumerate(chunks):
                shader.set_uniforms(
                    program, **(uniforms | {"shadow_count": shadows, "last_chunk": k == len(chunks) - 1})
                )
                self._dispatch(program, shadows)
        clock.append(time.perf_counter())
        self.statistics.add(level, now.count, heads, shadows, *(1000 * float(b - a) for a, b in pairwise(clock)))
        return cast

    def _cast(self, structure, first: int, count: int, stride: int, most_layers: int) -> None:
        """Find what the heads from `first` on meet: their layers, or with a stride of 1 the nearest hit."""
        self._layers_hit.extend(16 * stride * (first + count))
        if stride == 1:
            cast(structure, "closest", self._heads, self._layers_hit, count, first)
            return
        program = self._program("layers", structure)
        structure.bind(program)
        self._heads.bind(RAYS_UNIT)
        self._layers_hit.buffer.bind_to_storage_buffer(0)
        shader.set_uniforms(program, first_head=first, head_count=count, stride=stride, most_layers=most_layers)
        self._dispatch(program, count)

    def _bind_surfaces(self) -> None:
        self.triangles.corners.bind(12)
        self.triangles.attributes.bind(13)
        self._materials.bind(14)

    def _shades(self, settings: TraceSettings) -> list:
        """The programs that shade hits of cloth, and everything else."""
        return [self._program("shade", None, {"CLOTH": cloth, "SPREAD": int(settings.spread)}) for cloth in (1, 0)]

    def _program(self, name: str, structure=None, defines: dict | None = None):
        key = name, structure.source if structure else None, *(defines or {}).values()
        if key not in self._programs:
            virtual = {"count.glsl": "inputs/accel/count_none.glsl"} | (
                {"accel.glsl": structure.source} if structure else {}
            )
            self._programs[key] = shader.compute(self.ctx, f"passes/tracing/{name}.comp", defines, virtual)
        return self._programs[key]

    def _run(self, name: str, invocations: int, **uniforms) -> None:
        program = self._program(name)
        shader.set_uniforms(program, **uniforms)
        self._dispatch(program, invocations)

    def _dispatch(self, program, invocations: int) -> None:
        """Run a pass of 64 invocations a group; what it wrote is visible to all that follows."""
        program.run(-(-invocations // 64))
        self.ctx.memory_barrier()

    def release(self) -> None:
        """Free the GPU's memory."""
        for thing in (
            self.queries, self._heads, self._layers_hit, self._order,
            self._shadows, self._counts, self.picture, self._work, self._materials, self._fabric,
            *self._generations, *self._programs.values(), *self._structures.values(),
        ):  # fmt: skip
            thing.release()
        if self._environment[1] is not None:
            self._environment[1].release()
        if self._layers is not None:
            self._layers.release()


def _set_transmission(program, fabric: Fabric) -> None:
    """The uniforms of inputs/tracing/transmission.glsl."""
    shader.set_uniforms(program, **fabric.transmission.model_dump())


def sample_offsets(spp: int) -> list[tuple[float, float]]:
    """Where in the pixel the samples lie, from its centre: the R2 sequence, a single sample in the middle.

    Roberts 2018, "The unreasonable effectiveness of quasirandom sequences": evenly spread for any number of samples.
    """
    if spp == 1:
        return [(0.0, 0.0)]
    g = 1.32471795724474602596
    return [(float((0.5 + n / g) % 1.0 - 0.5), float((0.5 + n / g**2) % 1.0 - 0.5)) for n in range(spp)]


def _tiles(width: int, height: int, pixels: Callable[[], int] | None = None):
    """((first pixel), (blocks of pixels)) of bands of whole rows, or of parts of one row of blocks if those are too long."""
    w, h = BLOCK
    y = 0
    while y < height:
        count = TILE_PIXELS if pixels is None else pixels()
        # Parts of rows begin and end between blocks, so that no pixel is in two of them.
        across = min(width, max(w, count // h // w * w))
        rows = max(h, count // across // h * h) if across == width else h
        for x in range(0, width, across):
            yield (x, y), (-(-min(across, width - x) // w), -(-min(rows, height - y) // h))
        y += rows


def _texture(ctx: moderngl.Context, environment: Environment) -> moderngl.Texture:
    height, width = environment.radiance.shape[:2]
    texture = ctx.texture((width, height), 3, environment.radiance.tobytes(), dtype="f4", alignment=4)
    texture.repeat_x, texture.repeat_y = True, False
    texture.filter = moderngl.LINEAR, moderngl.LINEAR
    return texture
