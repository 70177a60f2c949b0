"""Progressive path tracing of cloth, objects and a ground under a sky: the judge of the other methods.   [own, docs/path.md]"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import moderngl
import numpy as np

from ..accel.ground import OverGround
from ..accel.structure import Structure, Traced, make_structure
from ..accel.triangles import Triangles
from ..color import luminance
from ..geometry.camera import Camera
from ..geometry.mesh import Mesh
from ..gpu.buffers import Buffer, TextureBuffer
from ..gpu.layout import constant
from ..gpu.memo import Last
from ..gpu.programs import Compute, programs
from ..gpu.scene_buffers import fabric_records
from ..progress import track
from ..visibility.hit_vertices import HitSurface, HitVertices
from ..visibility.sheets import Sheets, sight
from .energy import mean_albedo, reflection_limit
from .lamp import Lamp
from .path_threads import INCLUDE, PathThreads, ThreadDispatch
from .path_world import PathPictureArray, PathWorld
from .sky import Sky

STRUCTURE = "lbvh"
BATCH = 4  # samples a dispatch: more may run into llvmpipe's 65,535 loop iterations, which ends them without an error;
SHEER_BATCH = 1  # nor may rays to the light that go through up to eight layers of cloth, from up to 24 surfaces
FIRST_PART = 1 << 14  # pixels of the first dispatch; then as many as take about PATIENCE
PATIENCE = 0.2  # seconds between two chances to stop
TEXELS = 3  # of passes/tracing/path.comp
SAMPLES = 64  # of a picture that says neither how many nor how little noise; one sample shows nothing
MOST_SAMPLES = 1 << 20  # of one that says how little noise
LEAST_SAMPLES = 16  # before the noise is believed
BLOCK = 8  # samples, from whose sums the noise is found: samples fill their intervals, and are not independent of each other


class PathView(NamedTuple):
    """How a picture is taken: `vertices` is the most surfaces on a path that scatter; `background` whether the map is seen;
    `lamp`: a point that gives light; `spread`: what yarns let through is drawn from their lobes, whose narrow ones else go
    straight on; `threads`: of each fabric that is worn the metres in a UV unit, None where no pixel can show its threads; ():
    no pixel shows any."""

    camera: Camera
    size: tuple[int, int]
    environment: dict[str, Any]  # environment_map and map_from_world
    background: bool = True
    vertices: int = 24
    lamp: Lamp | None = None
    spread: bool = False
    threads: tuple[float | None, ...] = ()


@dataclass(frozen=True, eq=False)
class PathSums:
    """What the samples of a picture add up to; arrays with the top row first.

    Parameters
    ----------
    samples : per pixel
    light : [H, W, 3]
    squares, begun : [H, W], of blocks of BLOCK samples the luminance of each squared; the luminance of the block begun
    normal, albedo, cover : [H, W, 3], [H, W, 3] and [H, W], of what is seen first
    """

    samples: int
    light: np.ndarray
    squares: np.ndarray
    begun: np.ndarray
    normal: np.ndarray
    albedo: np.ndarray
    cover: np.ndarray

    @property
    def picture(self) -> np.ndarray:
        """float32 [H, W, 4]: the mean light, and how much of a pixel is covered."""
        rgba = np.concatenate([self.light, self.cover[..., None]], -1) / self.samples
        return rgba.astype(np.float32)

    @property
    def standard_error(self) -> np.ndarray:
        """Of the luminance of each pixel [H, W] float32, one standard deviation; infinite for less than two blocks of samples.

        It is that of independent blocks, whose samples fill their intervals; over all samples they are filled more finely,
        so that it is rather too large.
        """
        blocks = self.samples // BLOCK
        if blocks < 2:
            return np.full(self.squares.shape, np.inf, np.float32)
        Y = (luminance(self.light.astype(float)) - self.begun) / blocks
        of_a_block = np.maximum(self.squares / blocks - Y * Y, 0.0) * blocks / (blocks - 1)
        return np.sqrt(of_a_block / (BLOCK * self.samples)).astype(np.float32)

    @property
    def noise(self) -> float:
        """The mean standard error of the pixels that show surfaces, in % of their mean luminance; of all where none does.

        A deviation that is found from few blocks is too small in the mean (its square is not): for normal ones by
        (4 n - 4) / (4 n - 3).   [Gurland, Tripathi 1971]
        """
        shown = self.cover > 0
        shown = shown if shown.any() else np.ones_like(shown)
        Y = float(luminance(self.light.astype(float))[shown].mean()) / self.samples
        blocks = max(self.samples // BLOCK, 2)
        of_few = (4 * blocks - 3) / (4 * blocks - 4)
        return 100.0 * of_few * float(self.standard_error[shown].mean(dtype=float)) / max(Y, 1e-30)

    def facts(self) -> dict[str, Any]:
        """How far they are, in plain values; None for noise that is not known yet."""
        noise = self.noise
        return {"samples": self.samples, "noise_percent": round(noise, 4) if np.isfinite(noise) else None}


@dataclass
class Progress:
    """How far a picture is: samples of all pixels, pixels of the next ones, and the noise when it was last looked at."""

    samples: int = 0
    pixels: int = 0
    noise: float = field(default=np.inf)


def samples_of(spp: int, noise: float) -> int:
    """How many samples a pixel gets at most, by what a scene says."""
    if spp > 1:
        return spp
    return MOST_SAMPLES if noise > 0.0 else SAMPLES


def followed(steps: Iterator[Progress], batch: int, samples: int, noise: float) -> Iterator[Progress]:
    """Those steps that finish samples of all pixels, with a progress bar; parameters as for PathTracer.steps."""
    count = None if noise > 0.0 else -(-samples // batch)
    return iter(track((progress for progress in steps if progress.pixels == 0), "path: samples, some at a time", count))


class PathTracer:
    """Traces one picture at a time; what does not change from one to the next stays on the GPU."""

    def __init__(self, ctx: moderngl.Context):
        self.ctx = ctx
        self.sky = Sky(ctx)
        self.progress = Progress()
        self._hits = HitVertices(ctx)
        self._sheets = Sheets(ctx, self._hits)
        self._tree: Structure = make_structure(ctx, STRUCTURE)
        self._triangles: Triangles | None = None
        self._solid, self._cloth, self._fabric = TextureBuffer(ctx, 16), TextureBuffer(ctx, 64), TextureBuffer(ctx, 16)
        self._sums = Buffer(ctx, 16)
        self._pictures = PathPictureArray(ctx)
        self._threads = PathThreads(ctx)
        self._built: Last[None] = Last()
        self._dressed: Last[None] = Last()
        self._size = (0, 0)
        self._part = FIRST_PART

    def take(self, world: PathWorld) -> None:
        """Take what paths meet."""
        self._world = world
        meshes = tuple(mesh for mesh, _ in (*world.cloths, *world.solids))
        passing = world.passing
        self._built.get(lambda: self._build(meshes, passing), meshes, passing)
        self._dressed.get(self._dress, *world.key)

    def _build(self, meshes: tuple[Mesh, ...], passing: tuple[bool, ...]) -> None:
        if self._triangles is not None:
            self._triangles.release()
        corners = np.concatenate([mesh.positions[mesh.triangles] for mesh in meshes])
        # Material 0 is what light passes through.
        material = [np.full(len(mesh.triangles), k >= len(passing) or not passing[k]) for k, mesh in enumerate(meshes)]
        self._triangles = Triangles.of(self.ctx, corners, np.concatenate(material).astype(int))
        self._tree.build(self._triangles)
        self._hits.prepare([HitSurface(mesh, mesh) for mesh in meshes], self._triangles)

    def _dress(self) -> None:
        """Upload what surfaces reflect and let through."""
        cloth_of, fabrics = zip(*self._world.worn, strict=True)
        ends = np.cumsum([len(mesh.triangles) for mesh, _ in self._world.cloths])[list(cloth_of)]
        rows = np.zeros((len(fabrics), 8, 4), "f4")
        stride = 16 * (4 + int(constant("MAX_TANGENTS")))
        records = b""
        for row, fabric, end in zip(rows, fabrics, ends, strict=True):
            counts = [sum(t.yarn == j for t in fabric.tangents) for j in (0, 1)]
            row[0] = *counts, fabric.sigma, fabric.gap
            row[2, 3], row[3, 2] = end, 1.0
            if (t := fabric.transmission) is not None:
                row[1], row[2, :3] = (t.rho, t.k_a, t.k_t, t.diffuse), t.tau
                row[3] = t.eta_1, t.eta_2, reflection_limit(fabric), 1.0
                row[5, :2] = t.roughness, t.roughness_p
            row[4, :3] = row[3, 2] * mean_albedo(fabric)
            records += fabric_records(fabric).ljust(stride, b"\0")
        pictures = self._pictures.take(self._world)
        of = np.array(cloth_of)
        rows[:, 5, 2:], rows[:, 6] = pictures.of_cloths[of], pictures.repeats[of]
        rows[:, 4, 3], rows[:, 7] = pictures.mask_rows[of], pictures.masks[of]
        self._cloth.write(rows)
        self._fabric.write(records)
        solid = [reflectance for _, reflectance in self._world.solids]
        ground = self._world.ground[1] if self._world.ground is not None else (0.0, 0.0, 0.0)
        colors = np.concatenate([*solid, np.reshape(ground, (1, 3))])
        self._solid.write(np.concatenate([colors, pictures.of_solids[:, None]], 1).astype("f4"))
        self._sheer = self._sheets.prepare(
            [fabric.transmission for fabric in fabrics], any(self._world.passing), surfaces=cloth_of
        )

    def _inputs(self, view: PathView) -> dict[str, Any]:
        right, up, _ = view.camera.axes
        radius = 0.5 * view.camera.aperture
        world = self._world
        return {
            **self.structure.inputs(),
            **self._hits.inputs_of_hits(),
            **(self._sheer.inputs() if self._sheer is not None else {}),
            **self.sky.inputs(),
            **view.environment,
            **self.fabric_inputs(),
            **self._pictures.inputs(),
            "solid_data": self._solid,
            "cloth_count": len(world.worn),
            "cloth_triangles": self._hits.first_triangle[len(world.cloths)],
            "solid_triangles": self._hits.first_triangle[-1] - self._hits.first_triangle[len(world.cloths)],
            "background": view.background,
            "size": view.size,
            "most_vertices": view.vertices,
            **_lamp_inputs(view.lamp),
            **self._catcher_inputs(),
            **({"spread": view.spread} if self._sheer is not None else {}),
            "ray_from_pixel": view.camera.ray_from_pixel(view.size),
            "origin_from_pixel": view.camera.origin_from_pixel(view.size),
            "lens_x": tuple(radius * right),
            "lens_y": tuple(radius * up),
            "focus": view.camera.focus_distance,
        }

    def _catcher_inputs(self) -> dict[str, Any]:
        catcher = self._world.catcher
        if catcher is None:
            return {}
        light = max(float(luminance(self.sky.open_irradiance())), 1e-30)
        return {"catcher_middle": catcher.middle, "catcher_fade": catcher.fade, "open_luminance": light}

    def fabric_inputs(self) -> dict[str, Any]:
        """What inputs/tracing/path_fabric.glsl reads of the cloths."""
        return {"cloth_data": self._cloth, "fabric_data": self._fabric}

    @property
    def batch(self) -> int:
        """How many samples a dispatch adds, of what was taken."""
        return BATCH if self._sheer is None else SHEER_BATCH

    @property
    def structure(self) -> Traced:
        """What rays through the world that was taken meet: the triangles of cloths and solids in their order, the ground."""
        ground = self._world.ground
        return self._tree if ground is None else OverGround(self._tree, ground[0])

    def _dispatches(self, view: PathView) -> list[ThreadDispatch]:
        """What each batch of samples takes: one dispatch, or one for each fabric that shows threads."""
        fabrics = [fabric for _, fabric in self._world.worn]
        units = view.threads or (None,) * len(fabrics)
        shown = self._threads.dispatches(fabrics, units, view.camera, view.size)
        uv = self._pictures.uv_inputs(self._world) if shown else {}
        return [ThreadDispatch(one.defines, {**one.inputs, **uv}) for one in shown] or [ThreadDispatch({}, {})]

    def _program(self, threads: dict[str, Any]) -> Compute:
        defines, virtual, _ = sight(self.structure, self._sheer, "inputs/tracing/sight_either.glsl")
        if self._pictures.any:
            defines = {**defines, "PICTURES": 1}
        if self._world.catcher is not None:
            defines = {**defines, "CATCHER": 1}
        virtual["sky.glsl"] = self.sky.source
        if threads:
            defines, virtual = {**defines, **threads}, {**virtual, **INCLUDE}
        if self._sheer is not None:
            virtual["sight.glsl"] = "inputs/tracing/sight_sheer.glsl"
        return programs(self.ctx).compute("passes/tracing/path.comp", defines, virtual)

    def steps(
        self, view: PathView, samples: int, noise: float = 0.0, patience: Callable[[], float] | None = None
    ) -> Iterator[Progress]:
        """Trace a picture of what was taken, under the light of `sky`, from its first sample on; yields after each dispatch.

        Parameters
        ----------
        samples : per pixel, at most
        noise : stop where `PathSums.noise` is that small, %; 0: never
        patience : how long a dispatch may take, seconds; None: PATIENCE
        """
        pixels = view.size[0] * view.size[1]
        self._size = view.size
        self._sums.write(np.zeros((pixels, TEXELS, 4), "f4"))
        progress = self.progress = Progress()
        inputs, look = self._inputs(view), LEAST_SAMPLES
        parts = [(self._program(one.defines), one.inputs) for one in self._dispatches(view)]
        while progress.samples < samples:
            count = min(self.batch, samples - progress.samples)
            while progress.pixels < pixels:
                begin, part = time.perf_counter(), min(self._part, pixels - progress.pixels)
                where = {"first_pixel": progress.pixels, "pixel_count": part}
                which = {"first_sample": progress.samples, "sample_count": count}
                for k, (program, own) in enumerate(parts):
                    # A block ends when all parts of its samples are there.
                    block = BLOCK if k + 1 == len(parts) else MOST_SAMPLES + BATCH
                    program.run(part, inputs, where, which, own, block=block, Sums=self._sums)
                self.ctx.finish()  # so that progress tells the truth and Ctrl-C is heard
                progress.pixels += part
                took, wanted = time.perf_counter() - begin, patience() if patience else PATIENCE
                if part == self._part:
                    self._part = int(np.clip(part * np.clip(wanted / max(took, 1e-4), 0.5, 2.0), 1 << 10, 1 << 22))
                if progress.pixels < pixels:
                    yield progress
            progress.samples, progress.pixels = progress.samples + count, 0
            if noise > 0.0 and progress.samples >= look:
                look = progress.samples + max(BATCH, progress.samples // 4)
                progress.noise = self.sums().noise
                if progress.noise <= noise:
                    yield progress
                    return
            yield progress

    def inputs(self) -> dict[str, Any]:
        """What passes/picture/path.frag reads."""
        return {"Sums": self._sums, "size": self._size}

    def sums(self) -> PathSums:
        """What the whole samples so far add up to, read from the GPU."""
        width, height = self._size
        data = np.frombuffer(self._sums.read(16 * TEXELS * width * height), "f4").reshape(height, width, TEXELS, 4)[
            ::-1
        ]
        albedo = data[..., 2, :3].copy()
        return PathSums(
            max(self.progress.samples, 1),
            data[..., 0, :3].copy(),
            data[..., 0, 3].copy(),
            data[..., 2, 3].copy(),
            data[..., 1, :3].copy(),
            albedo,
            data[..., 1, 3].copy(),
        )

    def release(self) -> None:
        """Free the GPU's memory."""
        parts = (
            self.sky,
            self._hits,
            self._sheets,
            self._tree,
            self._solid,
            self._cloth,
            self._fabric,
            self._sums,
            self._pictures,
            self._threads,
        )
        for one in parts:
            one.release()
        if self._triangles is not None:
            self._triangles.release()


def _lamp_inputs(lamp: Lamp | None) -> dict[str, Any]:
    if lamp is None:
        none = (0.0, 0.0, 0.0)
        return {"lamp": none, "intensity": none, "has_lamp": False, "lamp_x": none, "lamp_y": none}
    x, y = (tuple(map(float, axis)) for axis in lamp.axes)
    return {"lamp": lamp.position, "intensity": lamp.intensity, "has_lamp": True, "lamp_x": x, "lamp_y": y}
