"""The ray tracer of paper B: any triangles, of cloth and of other materials, in the light of a lamp.   [Mat section 4.2]

`rays` traces generation by generation; this file holds the scene, its structures, light and camera. Large pictures
are made in tiles.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Generator, Iterator
from typing import Any

import moderngl
import numpy as np

from ..accel.structure import Structure, make_structure
from ..accel.triangles import PADDING, Triangles
from ..gpu.buffers import Buffer, LateRead, TextureBuffer, read_together
from ..gpu.context import is_software
from ..gpu.environment_map import EnvironmentMap
from ..gpu.scene_buffers import SceneBuffers
from ..light.environment import rotation_y
from ..progress import track
from .energy import mean_albedo, reflection_limit
from .fabrics import Fabrics, straight_share
from .layers import draw_layers
from .rays import BLOCK, KINDS, Picture, Rays, Tile
from .shot import Shot, TraceStatistics
from .threads import Threads

TILE_PIXELS = 1 << 17  # rays of the first generation at a time; each causes up to 2^(depth - 1) more
# A GPU waits for the CPU once a tile, and has the memory: 16 tiles of 1920x1080 take twice as long as two.
GPU_TILE_PIXELS = 1 << 20
OFF = 8  # times the padding of boxes: how far off the surface new rays begin


class Tracer:
    """Traces triangles of cloth and of other materials on one OpenGL context.

    `render` does everything for arrays; a moving cloth uses `set_scene`, `build` and `trace` each frame.
    """

    def __init__(self, ctx: moderngl.Context):
        self.ctx = ctx
        self.statistics = TraceStatistics()
        self.picture = Buffer(ctx, 64)
        self._parts = Buffer(ctx, 64)
        self._structures: dict[str, Structure] = {}
        self._triangles: Triangles | None = None
        self._materials = TextureBuffer(ctx, 64)
        self._fabric = SceneBuffers(ctx)
        self._fabrics = Fabrics(ctx)
        self._environment = EnvironmentMap(ctx)
        self._rays = Rays(ctx)
        self._threads = Threads(ctx)
        self._software = is_software(ctx)
        self._confirmed: tuple | None = None  # what the last picture was of that is known to have had room
        self._open = False  # whether the last picture was begun with a structure that nobody had looked at
        self.remade = 0  # how many pictures had none

    # -- the scene -----------------------------------------------------------------------------------------------

    def set_scene(self, triangles: Triangles, materials: np.ndarray) -> None:
        """Trace these triangles from now on.

        materials : [M, 3] diffuse reflectances, linear Rec. 709; material 0 is the cloth, its reflectance is ignored
        """
        self._triangles = triangles
        records = np.zeros((len(materials), 4), np.float32)
        records[:, :3] = materials
        records[0, 3] = 1.0
        self._materials.write(records)

    @property
    def triangles(self) -> Triangles:
        """Those of the scene that was set."""
        assert self._triangles is not None, "call set_scene first"
        return self._triangles

    def structure(self, name: str) -> Structure:
        """The acceleration structure of a name, made at first use. Raises InputError for an unknown one."""
        if name not in self._structures:
            self._structures[name] = make_structure(self.ctx, name)
        return self._structures[name]

    def build(self, accelerator: str = "kdtree") -> None:
        """Build the structure of the triangles as they are now."""
        self.structure(accelerator).build(self.triangles)

    def build_steps(self, accelerator: str = "kdtree", later: bool = False) -> Iterator[None]:
        """As `build`, in steps where the structure has some, for a caller with other things to do in between.

        later : the CPU does not wait to see whether the structure had room, where it may be told later; `trace` and `steps`
            find out, and build it anew
        """
        yield from self.structure(accelerator).build_steps(self.triangles, later)

    def confirm(self, accelerator: str) -> None:
        """Wait to see whether a structure that was built with `later` had room, and else build it anew: for what sends rays
        through it beside `trace` and `steps`."""
        structure = self.structure(accelerator)
        if (counters := structure.unread) is not None and not structure.fits(counters.read()):
            structure.build(self.triangles)

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
        triangles = Triangles(self.ctx, len(positions), max(scale, shot.camera.reach))
        triangles.set(0, positions, normals, tangents, material)
        try:
            self.set_scene(triangles, materials)
            self.build(shot.settings.accelerator)
            return self.trace(shot)
        finally:
            triangles.release()
            self._triangles = None

    # -- tracing -------------------------------------------------------------------------------------------------

    def trace(self, shot: Shot) -> np.ndarray:
        """Trace one picture of the scene that was set and built; result as for `render`."""
        width, height = shot.size
        begin = time.perf_counter()
        steps = self._tiles_traced(shot, None)
        total = len(list(_tiles(width, height, self._tile_pixels))) * len(shot.samples) + (shot.renewed is not None)
        # Light that is found anew takes steps of its own, nobody knows how many.
        what, most = ("trace: photons and tiles", None) if shot.renewed else ("trace: samples of tiles", total)
        for _ in track(steps, what, most) if total > 1 else steps:
            pass
        while True:
            data, *unread = read_together(self.ctx, [(self.picture, 16 * width * height), *self._unread(shot)])
            if self._fits(shot, unread):
                break
            self._anew(shot)
            for _ in self._tiles_traced(shot, None):
                pass
        picture = np.frombuffer(data, np.float32).reshape(height, width, 4)
        self.statistics.total_ms = 1000 * (time.perf_counter() - begin)
        return picture[..., :3].copy()

    def _unread(self, shot: Shot) -> list[tuple[Buffer, int]]:
        """The buffers that say whether there was room for all of a picture, and how many of their bytes."""
        counters = self.structure(shot.settings.accelerator).unread
        tree = [] if counters is None else [(counters, counters.size)]
        rays = self._rays.unread
        return [*tree, *([rays] if rays[1] else [])]

    def _fits(self, shot: Shot, read: list[bytes]) -> bool:
        """Whether there was room, by what was read of `_unread`; else there is more now."""
        structure, has_rays = self.structure(shot.settings.accelerator), bool(self._rays.unread[1])
        tree = read[: len(read) - has_rays]
        # Where somebody else has looked since, as a picture of the tree does, it may have been built anew after the rays.
        if self._open and (not tree or structure.unread is None or not structure.fits(tree[0])):
            return False
        fits = not has_rays or self._rays.fits(read[-1], self.statistics)
        self._confirmed = self._key(shot) if fits else None
        return fits

    def _anew(self, shot: Shot) -> None:
        """Build the structure that had no room, and was no tree, once more."""
        structure = self.structure(shot.settings.accelerator)
        structure.build(self.triangles)
        self.remade += 1

    def _key(self, shot: Shot) -> tuple:
        """What decides about how many rays there are: where it stays the same, so do they, nearly."""
        return shot.size, shot.settings, self.triangles.count, shot.fabric.name

    def steps(self, shot: Shot, pixels: Callable[[], int] | None = None) -> Iterator[float]:
        """Trace one picture tile by tile into the buffer `picture`, for a caller with other things to do in between.
        The result does not depend on the tiles. A picture that had no room is made again at the end.

        pixels : called before each row of tiles: about how many pixels each of them shall have; default: by the device

        Yields the share that is done. `picture` holds a vec4 a pixel, top row first: linear Rec. 709, already divided by
        the number of samples, and how many samples have been added.
        """
        while True:
            yield from self._tiles_traced(shot, pixels)
            parts = self._unread(shot)
            read = (yield from self._late(parts)) if parts else []
            if self._fits(shot, read):
                return
            self._anew(shot)

    def _late(self, parts: list[tuple[Buffer, int]]) -> Generator[float, None, list[bytes]]:
        """What buffers hold, when the GPU has come so far."""
        late = LateRead(self.ctx, parts)
        try:
            while (read := late.data()) is None:
                yield 1.0
            return read
        finally:
            late.release()

    def _tiles_traced(self, shot: Shot, pixels: Callable[[], int] | None) -> Iterator[float]:
        """As `steps`, but whether there was room is known only by what is `_unread` then."""
        width, height = shot.size
        structure = self.structure(shot.settings.accelerator)
        later = shot.renewed is None and self._confirmed == self._key(shot)
        self._open = structure.unread is not None
        self._rays.begin()
        self.statistics = TraceStatistics(build_ms=dict(structure.timings))
        begin = time.perf_counter()
        inputs = self.inputs(shot) | self._way_inputs(shot)
        picture = Picture(shot, structure, inputs, self.picture, self.statistics, self._parts if shot.parted else None)
        self.picture.write(bytes(16 * width * height))
        if shot.parted:
            self._parts.write(bytes(16 * KINDS * width * height))
        done, lamp = 0, shot.lighting.lamp
        lamps = lamp.points(len(shot.samples))
        for sample, camera in enumerate(shot.cameras):
            for found in shot.renewed(sample) if shot.renewed else ():
                inputs.update(found)
                yield done / (width * height * len(shot.samples))
            if lamp.radius:
                inputs.update(lamp=tuple(map(float, lamps[sample])))
            inputs.update(
                origin_from_pixel=camera.origin_from_pixel(shot.size), ray_from_pixel=camera.ray_from_pixel(shot.size)
            )
            for tile in _tiles(width, height, pixels or self._tile_pixels):
                self._rays.trace(picture, tile, sample, later)
                self.statistics.total_ms += 1000 * (time.perf_counter() - begin)
                done += tile.pixels(shot.size)
                yield done / (width * height * len(shot.samples))
                begin = time.perf_counter()

    def parts(self, size: tuple[int, int]) -> dict[str, np.ndarray]:
        """The kinds of light of the last picture, which a shot that is `parted` made: direct, bounce, transmission and
        background, float32 [H, W, 3] each, as `trace`; their sum is the picture."""
        width, height = size
        kinds = np.frombuffer(self._parts.read(16 * KINDS * width * height), np.float32).reshape(
            height, width, KINDS, 4
        )
        names = "direct", "bounce", "transmission", "background"
        return {name: kinds[:, :, k, :3].copy() for k, name in enumerate(names)}

    def _tile_pixels(self) -> int:
        return TILE_PIXELS if self._software else GPU_TILE_PIXELS

    def layers(self, shot: Shot) -> np.ndarray:
        """Rasterise the scene that was set instead: sorted layers, blended, without shadows, before the lighting's
        background; result as for `trace`."""
        triangles, background = self.triangles, shot.lighting.background
        cloth, inputs = triangles.materials() == 0, self.inputs(shot)
        return draw_layers(self.ctx, triangles.positions(), cloth, shot.camera, shot.size, background, inputs)

    def inputs(self, shot: Shot) -> dict[str, Any]:
        """The inputs of inputs/tracing/local_light.glsl: surfaces, fabric and light."""
        limit = reflection_limit(shot.fabric)
        self._fabric.prepare(shot.fabric)
        return {
            "corner_data": self.triangles.corners,
            "attribute_data": self.triangles.attributes,
            "material_data": self._materials,
            **self._fabric.inputs(),
            **shot.transmission.model_dump(),
            "reflection_limit": limit,
            "cloth_albedo": tuple(map(float, mean_albedo(shot.fabric) * limit)),
            "lamp": shot.lighting.lamp.position,
            "intensity": shot.lighting.lamp.intensity,
            "ambient": shot.lighting.ambient,
            "straight_share": straight_share(shot.transmission, shot.indirect is not None),
            # The scene lies within `scale` of the middle along each axis: this far from any of its points is outside.
            "beyond": 2 * 3**0.5 * self.triangles.padding / PADDING,
            "offset": OFF * self.triangles.padding,
            **self._fabrics.inputs(shot),
            **(shot.indirect or {}),
        }

    def _way_inputs(self, shot: Shot) -> dict[str, Any]:
        """More inputs of the passes of `rays`: where rays begin and end, and the background beyond the scene."""
        scale = self.triangles.padding / PADDING
        sky = {} if shot.environment is None else {"environment_map": self._environment.texture(shot.environment)}
        return {
            "far": 4.0 * (scale + shot.camera.reach) * 3**0.5,
            "cutoff": shot.settings.cutoff,
            "background": shot.lighting.background,
            "environment_from_world": rotation_y(-shot.env_rotate),
            "has_environment": shot.environment is not None,
            **sky,
            **self._threads.inputs(shot),
        }

    def release(self) -> None:
        """Free the GPU's memory."""
        for thing in (
            self.picture,
            self._parts,
            self._materials,
            self._fabric,
            self._fabrics,
            self._environment,
            self._rays,
            self._threads,
        ):
            thing.release()
        for structure in self._structures.values():
            structure.release()


def _tiles(width: int, height: int, pixels: Callable[[], int]) -> Iterator[Tile]:
    """Bands of whole rows, or parts of one row of blocks if those are too long."""
    w, h = BLOCK
    y = 0
    while y < height:
        count = pixels()
        # Parts of rows begin and end between blocks, so that no pixel is in two of them.
        across = min(width, max(w, count // h // w * w))
        rows = max(h, count // across // h * h) if across == width else h
        for x in range(0, width, across):
            yield Tile((x, y), (-(-min(across, width - x) // w), -(-min(rows, height - y) // h)))
        y += rows
