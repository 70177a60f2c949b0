"""How far the pixels of a G-buffer see the lights, for the passes that shade them.   [own, docs/shadows.md]"""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import moderngl
import numpy as np

from ..accel.structure import Traced
from ..geometry.mesh import Mesh
from ..gpu.buffers import TextureBuffer
from ..gpu.gbuffer import GBuffer
from ..gpu.memo import Last, same
from ..gpu.programs import programs
from ..gpu.scene_buffers import SceneBuffers
from ..light.lights import Lights, SphericalGaussians
from ..scene import ShadowMode
from ..twins.visibility import own_directions
from .finer import SunOccluders
from .furnace import Furnace
from .hit_vertices import HitVertices
from .sheets import Passed, Sheets, sight
from .vertices import FEWEST, FLAT, NARROW, VertexVisibility, broad_number, sun_number, top_number

# Choices for "seen.glsl" in a program that shades.
SEEN_ALL, SEEN_PIXELS = "inputs/visibility/seen_all.glsl", "inputs/visibility/seen_pixels.glsl"
SEEN_OCCLUDERS = "inputs/visibility/seen_occluders.glsl"
TILE = 8  # pixels
MOVING_CLASSES = 8  # of probes on cloth that moves: each traces a quarter of its 32 directions at every pose
EDGE_RAYS = 16  # of a pixel into a narrow Gaussian, of all its samples together,
FEWEST_EDGE_RAYS = 4  # and of each
FEWEST_TILES = 32  # at a time
PATIENCE = 0.1  # seconds of rays from pixels between two looks at Ctrl-C
CUT = 2.0  # mean edges by which the vertices may move in the mean from pose to pose


@dataclass(frozen=True, eq=False)
class Occluders:
    """Everything that hides light and is not the mesh itself, and what all rays meet.

    Parameters
    ----------
    meshes : all others but a ground
    ground : whether there is one
    hit_vertices : the numbering of all that rays meet
    """

    meshes: tuple[Mesh, ...]
    ground: bool
    hit_vertices: HitVertices


class PixelVisibility:
    """Keeps the visibility of one mesh's vertices; a `PixelView` brings it to the pixels, and casts the suns' rays."""

    def __init__(self, ctx: moderngl.Context, steepness: float = FLAT):
        """`steepness`: see `VertexVisibility`."""
        self.ctx = ctx
        self.vertices = VertexVisibility(ctx, steepness)
        self.furnace = Furnace(ctx)
        self.mode: ShadowMode = "off"
        self.bounce = True
        self.follow = False
        self.occluders: Occluders | None = None
        self._structure: Traced | None = None
        self._sun_occluders: SunOccluders | None = None
        self.lights: Lights
        self.sheets: Sheets | None = None
        self.passed = Passed.of(None)  # what of even light comes through the mesh
        self.drawn_levels = 0  # how often the triangles that hide light were cut into four where they are drawn
        self.limit = 1.0  # by which its reflection is dimmed
        self._transmissions: tuple = ()
        self._meshes: tuple[Mesh, ...] = ()  # whose vertices were taken, and the others that hide light

    def follow_poses(self, follow: bool) -> None:
        """Take the next mesh with the same triangles for the next pose, or not."""
        if follow != self.follow:
            self.follow, self._meshes = follow, ()

    def prepare(
        self,
        mode: ShadowMode,
        mesh: Mesh,
        original: Mesh,
        structure: Traced | None,
        lights: Lights,
        bounce: bool = True,
        occluders: Occluders | None = None,
        sheets: Sheets | None = None,
        sun_occluders: SunOccluders | None = None,
    ) -> None:
        """Take meshes, lights and mode. `mesh` is drawn, `original` is the one before subdivision, `structure` holds
        all that hides light: the mesh and its `occluders`; None where the mode is "off". `sheets`: of the cloths, where
        any lets light through; `sun_occluders`: what hides suns from pixels; None: what the structure holds."""
        self._sun_occluders = sun_occluders
        self.drawn_levels = round(np.log2(len(mesh.triangles) / max(len(original.triangles), 1)) / 2)
        self.mode, self._structure, self.lights, self.bounce = mode, structure, lights, bounce
        before, self.occluders = self.occluders, occluders
        self.vertices.hit_vertices = None if occluders is None else occluders.hit_vertices
        self.sheets = self.vertices.sheets = sheets
        transmissions = () if sheets is None else sheets.transmissions
        if (occluders is None) != (before is None):
            self._meshes = ()  # rays must find what they end at
        if structure is not None and transmissions != self._transmissions:
            self._transmissions, self._meshes = transmissions, ()
        meshes = mesh, *self.others
        if mode == "full" and structure is not None and not same(self._meshes, meshes):
            if self.follow and is_next_pose(self._meshes, meshes):
                self.vertices.move(mesh, structure)
            else:  # a cut fills at once
                classes = MOVING_CLASSES if self.follow else None
                self.vertices.start(mesh, structure, original, classes)
            self._meshes = meshes

    @property
    def structure(self) -> Traced:
        """The structure of all that hides light."""
        assert self._structure is not None
        return self._structure

    @property
    def sun_occluders(self) -> SunOccluders:
        """What hides suns from pixels."""
        return self._sun_occluders or SunOccluders(self.structure)

    @property
    def others(self) -> tuple[Mesh, ...]:
        """The other meshes that hide light."""
        return () if self.occluders is None else self.occluders.meshes

    @property
    def transmissions(self) -> tuple:
        """Of all cloths, where any lets light through: the same objects as long as none changes."""
        return self._transmissions

    @property
    def over_ground(self) -> bool:
        """Whether a ground hides light from below the horizon."""
        return self.occluders is not None and self.occluders.ground

    @property
    def source(self) -> str:
        """The file for "seen.glsl" in a program that asks for these shadows."""
        return SEEN_PIXELS if self.occluders is None or self.mode != "full" else SEEN_OCCLUDERS

    # -- vertices ----------------------------------------------------------------------------------------------------

    @property
    def _sharp_lights(self) -> Lights | None:
        """Whose narrow Gaussians get directions of their own: these would all have to be traced at every pose."""
        return None if self.follow else self.lights

    def steps(self, count: int = 32, enough: int | None = None) -> Iterator[int]:
        """Trace the missing directions, `count` at a time; or only until there are `enough` of them."""
        if self.mode == "full" and enough is not None:
            while self.vertices.done < enough:
                self.vertices.step(count)
                self.ctx.finish()
                yield self.vertices.done
        elif self.mode == "full":
            yield from self.vertices.steps(self._sharp_lights, count)

    def total(self) -> int:
        """How many steps of 32 directions there are in all, about."""
        return -(-self.vertices.total(self._sharp_lights) // 32) if self.mode == "full" else 0

    def preview(self) -> None:
        """Trace only as much as a first impression needs."""
        if self.mode == "full":
            while self.vertices.done < FEWEST:
                self.vertices.step(FEWEST)

    def integrate(self, broad: np.ndarray | None) -> None:
        """Make the means of the vertices under the present lights; nothing when they are made.

        `broad`: see `VertexVisibility.integrate`; None: of each light alone, as a Lambertian needs them.
        """
        if self.mode == "full":
            self.vertices.integrate(self.lights, broad, self.over_ground)

    # -- how much a fabric reflects ----------------------------------------------------------------------------------

    def inputs(self, fabric: SceneBuffers) -> dict[str, Any]:
        """The bounce's inputs from the fabric of this mesh, by their names in GLSL."""
        if self.mode != "full" or not self.bounce or self.occluders is None:
            return {"albedo": np.zeros(3)}
        return {"albedo": self.furnace.albedo(fabric) * self.limit, "views": self.furnace.views(fabric)}


class PixelView:
    """The visibility of the pixels of one G-buffer, which shows one mesh, and the bounced light that they get."""

    def __init__(self, visibility: PixelVisibility, buffer: GBuffer):
        self.visibility, self.buffer, self.ctx = visibility, buffer, visibility.ctx
        self.seen: moderngl.TextureArray | None = None  # four values a texel, see inputs/visibility/seen_layers.glsl
        self._bounced: moderngl.TextureArray | None = None
        self._resolved: Last[None] = Last()
        self._bounce_resolved: Last[None] = Last()
        # rgb of each sun, see passes/visibility/suns_behind.comp; and what the first rays to suns found, of both sides.
        self._seen_behind: moderngl.TextureArray | None = None
        self._first: moderngl.TextureArray | None = None
        self._first_behind: moderngl.TextureArray | None = None
        self._behind_resolved: Last[None] = Last()
        self._sample = 0, 1
        self._numbers: dict[str, int] = {}  # where which value is
        self._edges_done = 0  # tiles from whose pixels rays went into the narrow Gaussians
        self._sun_data = TextureBuffer(self.ctx, 16)
        self._edge_data = TextureBuffer(self.ctx, 16)

    def resolve(self, broad: np.ndarray | None, sample: tuple[int, int] = (0, 1)) -> None:
        """Fill `seen` for the G-buffer as it is drawn now; nothing when it holds just that.

        Parameters
        ----------
        broad : as for `PixelVisibility.integrate`
        sample : the number of the sample in the pixel, and how many there are: `edges` shares its rays among them
        """
        visibility = self.visibility
        lights, count = visibility.lights, len(visibility.lights.gaussians)
        first = broad_number(count)
        first_sun = first if broad is None else sun_number(count)
        self._numbers = {"top_number": top_number(count), "broad_number": first, "sun_number": first_sun}
        self._sample = sample
        visibility.integrate(broad)
        seen = self.seen = _array(self.ctx, self.seen, self.buffer.size, first_sun // 4 + -(-len(lights.suns) // 4))
        version = visibility.vertices.version if visibility.mode == "full" else 0
        hidden = visibility.mode, visibility.structure, visibility.others, visibility.sun_occluders.structure
        key = lights, self.buffer.drawn, sample, *hidden, seen, version, visibility.transmissions
        self._resolved.get(lambda: self._fill(seen, first_sun // 4), *key)

    def _fill(self, seen: moderngl.TextureArray, sun_layer: int) -> None:
        visibility, buffer = self.visibility, self.buffer
        self._edges_done = 0
        program = programs(self.ctx).compute("passes/visibility/pixels.comp")
        numbers = {"group_count": sun_layer, "everything": visibility.mode != "full"}
        program.run(buffer.size, self._vertex_inputs(), numbers, mean_data=visibility.vertices.means, seen=seen)
        suns = visibility.lights.suns
        if len(suns):
            self._first = _array(self.ctx, self._first, buffer.size, -(-len(suns) // 4))
            self._see_suns("passes/visibility/suns.comp", self._first, first_layer=sun_layer, seen=seen)

    def _see_suns(self, path: str, first: moderngl.TextureArray, **names: Any) -> None:
        """Run a pass of inputs/visibility/sun_points.glsl: a ray from each pixel, then more where these do not agree."""
        visibility, buffer = self.visibility, self.buffer
        suns, (sample, samples) = visibility.lights.suns, self._sample
        self._sun_data.write(np.column_stack([suns.direction, np.tan(suns.radius)]).astype("f4"))
        defines, virtual, rays = visibility.sun_occluders.sight(visibility.sheets)
        inputs = rays | buffer.inputs() | self.drawn_inputs()
        inputs |= {"sun_data": self._sun_data, "first_turn": sample / samples}
        begin, rest = (programs(self.ctx).compute(path, own, virtual) for own in ({**defines, "FIRST": 1}, defines))
        begin.run(buffer.size, inputs, first_image=first, sun_count=len(suns))
        for number in range(len(suns)):
            rest.run(buffer.size, inputs, names, first_seen=first, sun_number=number)

    def _vertex_inputs(self) -> dict[str, Any]:
        """The inputs of passes that bring values of the vertices to the pixels."""
        assert self.buffer.drawn is not None
        return self.buffer.inputs() | {"corner_index": self.buffer.drawn.mesh.indices}

    def edges(self, seconds: float = PATIENCE) -> Iterator[int]:
        """Send rays into the narrow Gaussians from the pixels whose triangles' corners disagree on how far they see
        them, after `resolve`. Does nothing where that is done, or poses are followed.

        Parameters
        ----------
        seconds : of work, about, between two yields

        Yields how many tiles of the picture are done.
        """
        visibility = self.visibility
        width, height = (-(-side // TILE) for side in self.buffer.size)
        if visibility.mode != "full" or visibility.follow or self._edges_done >= width * height:
            return
        layers, directions = edge_layers(visibility.lights.gaussians, self._sample)
        if not layers:
            return
        self._edge_data.write(_texels(directions.reshape(-1, 3)))
        defines, virtual, rays = sight(visibility.structure, visibility.sheets)
        program = programs(self.ctx).compute("passes/visibility/narrow.comp", defines, virtual)
        inputs = rays | self._vertex_inputs()
        inputs |= {"mean_data": visibility.vertices.means, "group_count": visibility.vertices.groups, "seen": self.seen}
        inputs |= {"direction_data": self._edge_data, "direction_count": directions.shape[1], "row_tiles": width}
        count = FEWEST_TILES
        while self._edges_done < width * height:
            begin = time.perf_counter()
            count = min(count, width * height - self._edges_done)
            program.bind(inputs, first_tile=self._edges_done)
            for layer, begins in layers:
                program.run_groups(count, layer=layer, begin=begins)
            self.ctx.finish()
            self._edges_done += count
            faster = seconds / max(time.perf_counter() - begin, 1e-4)
            count = max(FEWEST_TILES, int(count * min(max(faster, 0.25), 4.0)))
            yield self._edges_done

    def forget_edges(self) -> None:
        """Let `edges` begin anew."""
        self._edges_done = 0

    def resolve_behind(self) -> None:
        """Find what is left of the suns on the other side of the mesh, which lets light through, for the G-buffer as it is
        drawn now."""
        visibility, buffer, suns = self.visibility, self.buffer, self.visibility.lights.suns
        if visibility.mode == "off" or not len(suns):
            return
        self._seen_behind = _array(self.ctx, self._seen_behind, buffer.size, len(suns))
        hidden = visibility.sun_occluders.structure, visibility.others, visibility.transmissions
        key = suns, buffer.drawn, self._sample, *hidden, self._seen_behind
        self._behind_resolved.get(self._fill_behind, *key)

    def _fill_behind(self) -> None:
        self._first_behind = _array(self.ctx, self._first_behind, self.buffer.size, len(self.visibility.lights.suns))
        self._see_suns("passes/visibility/suns_behind.comp", self._first_behind, seen_behind=self._seen_behind)

    def drawn_inputs(self) -> dict[str, Any]:
        """The vertices and corners of the mesh as it is drawn, by the names of inputs/visibility/origin_finer.glsl."""
        assert self.buffer.drawn is not None
        mesh = self.buffer.drawn.mesh
        names = {"drawn_vertices": mesh.vertices, "drawn_corners": mesh.indices}
        return names | {"drawn_levels": self.visibility.drawn_levels}

    def behind_inputs(self) -> dict[str, Any]:
        """Inputs of inputs/visibility/behind_means.glsl but for the lights and the irradiance table."""
        visibility = self.visibility
        full, gathers = visibility.mode == "full", visibility.bounce and visibility.occluders is not None
        return {
            **self.drawn_inputs(),
            "mean_data": visibility.vertices.means,
            "bounced_data": visibility.vertices.bounced,
            "group_count": visibility.vertices.groups,
            "sees_gaussians": not full,
            "sees_suns": visibility.mode == "off",
            "gathers": full and gathers,
            **({} if self._seen_behind is None else {"seen_behind": self._seen_behind}),
            **({} if self.seen is None else {"seen": self.seen}),
            **({} if self._bounced is None else {"bounced_light": self._bounced}),
        }

    def resolve_bounce(self) -> None:
        """Bring the vertices' bounced light (`Bounce.gather`) to the pixels of the G-buffer as it is drawn now."""
        vertices, buffer = self.visibility.vertices, self.buffer
        if self._bounced is None:
            self._bounced = self.ctx.texture_array((*buffer.size, 2), 4, dtype="f2")
            self._bounced.filter = moderngl.NEAREST, moderngl.NEAREST
        own = {"mean_data": vertices.bounced, "bounced_light": self._bounced}
        program = programs(self.ctx).compute("passes/visibility/bounce_pixels.comp")
        key = buffer.drawn, vertices.bounced_version
        self._bounce_resolved.get(lambda: program.run(buffer.size, self._vertex_inputs(), own), *key)

    def inputs(self, fabric: SceneBuffers | None = None) -> dict[str, Any]:
        """Inputs of the passes that shade these pixels, by their names in GLSL: of inputs/visibility/lit_means.glsl;
        with the mesh's `fabric`, of `PixelVisibility.source`."""
        names = {"seen": self.seen, "over_ground": self.visibility.over_ground, **self._numbers}
        if self._bounced is not None:
            names["bounced_light"] = self._bounced
        return names if fabric is None else names | self.visibility.inputs(fabric)

    def release(self) -> None:
        """Free the GPU's memory."""
        images = self.seen, self._bounced, self._seen_behind, self._first, self._first_behind
        for thing in (*images, self._sun_data, self._edge_data):
            if thing is not None:
                thing.release()


def _array(
    ctx: moderngl.Context, before: moderngl.TextureArray | None, size: tuple[int, int], layers: int
) -> moderngl.TextureArray:
    """Pictures of four bytes a pixel: those there were, or so many layers of others."""
    if before is not None and before.layers >= layers:
        return before
    if before is not None:
        before.release()
    images = ctx.texture_array((*size, layers), 4, dtype="f1")
    images.filter = moderngl.NEAREST, moderngl.NEAREST
    return images


def edge_layers(
    gaussians: SphericalGaussians, sample: tuple[int, int]
) -> tuple[list[tuple[int, tuple[int, ...]]], np.ndarray]:
    """Rays of one sample of a pixel into the narrow Gaussians.

    Returns each layer of `PixelView.seen` with values of such, with where the directions of its four values begin (-1:
    none), and the directions [N, rays, 3], of each Gaussian from the outside in, as the pass wants it.
    """
    narrow = np.flatnonzero(gaussians.sharpness >= NARROW)
    number, samples = sample
    total = max(EDGE_RAYS // samples, FEWEST_EDGE_RAYS) * samples
    own = [own_directions(gaussians.axis[k], gaussians.sharpness[k], total)[::-1][number::samples] for k in narrow]
    directions = np.stack(own) if own else np.zeros((0, total // samples, 3))
    begins = np.full(broad_number(len(gaussians)), -1)
    begins[1 + narrow] = directions.shape[1] * np.arange(len(narrow))
    fours = enumerate(begins.reshape(-1, 4))
    return [(layer, tuple(map(int, four))) for layer, four in fours if (four >= 0).any()], directions


def _texels(directions: np.ndarray) -> np.ndarray:
    return np.pad(directions, ((0, 0), (0, 1))).astype("f4")


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
