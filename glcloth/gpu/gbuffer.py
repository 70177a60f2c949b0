"""The G-buffer: which surface frame every pixel sees, and the camera rays that go with it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import moderngl
import numpy as np

from ..geometry.camera import Camera
from ..geometry.mesh import Mesh
from .buffers import TextureBuffer, read_texture
from .context_local import of_context
from .covered import Covered
from .memo import Last
from .programs import Compute, Draw, Inputs, programs
from .screen import draw_screen
from .tally import Tally

VERTEX_TEXELS = 3  # position, normal, tangent
FRAMES = {"frame_N": 4, "frame_x": 4, "frame_p": 4, "frame_b": 2}  # of passes/picture/surface.frag: components


@dataclass(frozen=True, eq=False)
class CutOut:
    """Where a mesh is not: the UVs of its vertices, and what passes/picture/surface.frag reads of an opacity map or a fabric
    mask, or both."""

    uv: TextureBuffer
    maps: Mapping[str, Any]

    def defines(self) -> dict[str, int]:
        """Which of the two there are."""
        names = {"opacity_map": "OPENINGS", "mask_map": "FABRIC_MASK"}
        return {"CUT_OUT": 1} | {define: 1 for name, define in names.items() if name in self.maps}


class MeshBuffers:
    """One mesh on the GPU, to be drawn and to be fetched from: `vertices` has VERTEX_TEXELS for each, `indices` three
    texels a triangle."""

    def __init__(
        self,
        ctx: moderngl.Context,
        mesh: Mesh,
        lift: np.ndarray | None = None,
        one_sided_from: int | None = None,
        cut_out: CutOut | None = None,
    ):
        """
        Parameters
        ----------
        lift : [V, 2] how far in front and behind the surface that hides light lies below the curved one, where it is
            coarser than the mesh
        one_sided_from : from this triangle on only the front is drawn
        cut_out : where it is not drawn; None: it is everywhere
        """
        self.mesh, self.cut_out = mesh, cut_out
        self.one_sided_from = len(mesh.triangles) if one_sided_from is None else one_sided_from
        vertices = np.zeros((len(mesh.positions), VERTEX_TEXELS, 4), "f4")
        vertices[:, 0, :3], vertices[:, 1, :3], vertices[:, 2] = mesh.positions, mesh.normals, mesh.tangents
        if lift is not None:
            vertices[:, 0, 3], vertices[:, 1, 3] = np.asarray(lift).T
        self.vertices = TextureBuffer(ctx, vertices)
        self.indices = TextureBuffer(ctx, mesh.triangles.astype("i4"), "r32i")
        self.low, self.high = mesh.positions.min(0), mesh.positions.max(0)
        self.numbers = TextureBuffer(ctx, np.arange(len(mesh.triangles), dtype="i4"), "r32i")
        self.band_indices = TextureBuffer(ctx, 16, "r32i")
        self.band_numbers = TextureBuffer(ctx, 16, "r32i")

    def heights(self, clip_from_world: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Where each triangle [T] begins and ends in the picture, from -1 below to 1 above; without end behind the eye."""
        points = self.mesh.positions @ clip_from_world[:, :3].T + clip_from_world[:, 3]
        before = points[:, 3] > 1e-6 * np.abs(points[:, 3]).max()
        y = points[:, 1] / np.where(before, points[:, 3], 1.0)
        corners = self.mesh.triangles
        low, high = (np.where(before, y, end)[corners] for end in (-np.inf, np.inf))
        return low.min(1), high.max(1)

    def choose(self, numbers: np.ndarray) -> None:
        """Put triangles [N] into the buffers of a band."""
        self.band_numbers.write(numbers.astype("i4"))
        self.band_indices.write(self.mesh.triangles[numbers].astype("i4"))

    def release(self) -> None:
        """Free the GPU's memory."""
        for thing in (self.vertices, self.indices, self.numbers, self.band_indices, self.band_numbers):
            thing.release()


@dataclass(frozen=True)
class Drawn:
    """What a G-buffer holds.

    Parameters
    ----------
    mesh, camera, offset : that were drawn, each pixel sampled at its centre + `offset`
    depths : near and far distance
    before : what the surfaces drawn before it held, which hide it where they are nearer
    behind : what the surfaces of the layer before it held, behind which it lies; none: it is of the first
    sheer : which of those are seen through
    """

    mesh: MeshBuffers
    camera: Camera
    offset: tuple[float, float]
    depths: tuple[float, float]
    before: tuple[Drawn, ...] = ()
    behind: tuple[Drawn, ...] = ()
    sheer: tuple[bool, ...] = ()


class GBuffer:
    """Frames and depth of one surface in one view; `shade` runs a program for each pixel that sees it."""

    def __init__(
        self,
        ctx: moderngl.Context,
        size: tuple[int, int],
        color: moderngl.Texture | None = None,
        parts: tuple[moderngl.Texture, ...] = (),
    ):
        """
        Parameters
        ----------
        color : the picture that it is shaded into, shared with the other surfaces; None: one of its own
        parts : of its light, as inputs/picture/parts.glsl has them; likewise
        """
        self.ctx, self.size = ctx, size
        self._textures = {name: ctx.texture(size, components, dtype="f4") for name, components in FRAMES.items()}
        self.color = ctx.texture(size, 4, dtype="f4") if color is None else color
        for texture in (*self._textures.values(), self.color):
            texture.filter = moderngl.NEAREST, moderngl.NEAREST
        self.depth = depth_texture(ctx, size)
        self.frames = ctx.framebuffer([*self._textures.values()], self.depth)
        self.parts = parts
        self.target = ctx.framebuffer([self.color, *parts], self.depth)
        self.ray_from_pixel = np.eye(3)
        self._drawn: Drawn | None = None
        self.drawings = 0  # how often other pixels were covered
        self._covered: dict[bool | None, Covered] = {}  # of the whole picture, and of its parts
        self._owns_color = color is None
        self._some: dict[bool, tuple[moderngl.Texture, moderngl.Framebuffer, Last[None]]] = {}

    def triangle_at(self, column: int, row: int) -> int | None:
        """The triangle that a pixel sees, counted from the bottom left one; None: it sees none."""
        counted = of_context(Tally, self.ctx)

        def alpha(name: str) -> float:
            place = list(FRAMES).index(name)
            texel = self.frames.read((column, row, 1, 1), 4, attachment=place, dtype="f4")
            counted.read(len(texel))
            return float(np.frombuffer(texel, "f4")[3])

        return None if alpha("frame_N") == 0.0 else int(alpha("frame_p"))

    # -- drawing -----------------------------------------------------------------------------------------------------

    def draw(self, mesh: MeshBuffers, camera: Camera, offset: tuple[float, float] = (0.0, 0.0)) -> None:
        """Fill the frames and the depth with one mesh alone, seen by `camera`, each pixel sampled at centre + `offset`."""
        wanted = Drawn(mesh, camera, offset, camera.depth_range(mesh.low, mesh.high))
        for _ in self.draw_bands(wanted, self.size[1]):
            pass

    def draw_bands(
        self,
        wanted: Drawn,
        rows: int,
        nearer: moderngl.Texture | None = None,
        behind: moderngl.Texture | None = None,
    ) -> Iterator[None]:
        """As `draw`, so many rows at a time, for a caller with other things to do in between.

        Parameters
        ----------
        wanted : what is drawn; nothing is done when the frames hold just that: an edit of fabric or light moves no pixel
        nearer : the depth of what stands before the mesh
        behind : the depth of what is seen through; nothing is drawn but behind it
        """
        if self._drawn == wanted:
            return
        self._drawn = None
        self.drawings += 1
        mesh, height = wanted.mesh, self.size[1]
        clip = wanted.camera.clip_from_world(self.size, *wanted.depths, wanted.offset)
        self.ray_from_pixel = wanted.camera.ray_from_pixel(self.size, wanted.offset)
        program = self._program(wanted, nearer, behind)
        if rows < height:
            low, high = mesh.heights(clip)
        for first in range(0, height, rows):
            numbers = None
            if rows < height:
                # A pixel more to either side, for the rasteriser rounds as it likes.
                below, above = (2.0 * (y / height) - 1.0 for y in (first - 1, first + rows + 1))
                numbers = np.flatnonzero((high >= below) & (low <= above))
            program.bind(clip_from_world=clip, viewpoint=wanted.camera.viewpoint)
            self._draw_band(mesh, program, (0, first, self.size[0], min(rows, height - first)), numbers)
            yield
        self._drawn = wanted

    def _program(self, wanted: Drawn, nearer: moderngl.Texture | None, behind: moderngl.Texture | None) -> Draw:
        alone = not wanted.before and wanted.mesh.one_sided_from == len(wanted.mesh.mesh.triangles) and behind is None
        paths = "passes/picture/surface.vert", "passes/picture/surface.frag"
        cut: dict[str, Any] = {} if wanted.mesh.cut_out is None else wanted.mesh.cut_out.defines()
        if alone:
            return _cut_out(programs(self.ctx).draw(*paths, cut), wanted)
        program = programs(self.ctx).draw(*paths, {"AMONG_OTHERS": 1} | ({} if behind is None else {"BEHIND": 1}) | cut)
        _cut_out(program, wanted)
        program.bind(one_sided_from=wanted.mesh.one_sided_from, hidden_by_others=nearer is not None)
        if nearer is not None:
            program.bind(nearer=nearer)
        if behind is not None:
            program.bind(behind=behind)
        return program

    def _draw_band(self, mesh: MeshBuffers, program: Draw, band: tuple[int, int, int, int], numbers) -> None:
        """Draw all triangles, or those of `numbers`, into a band of the frames."""
        self.frames.scissor = None if numbers is None else band  # type: ignore[assignment]
        self.frames.use()
        self.frames.viewport = (0, 0, *self.size)
        self.frames.clear(0.0, 0.0, 0.0, 0.0, depth=1.0, viewport=None if numbers is None else band)
        if numbers is not None:
            if not len(numbers):
                self.frames.scissor = None  # type: ignore[assignment]
                return
            mesh.choose(numbers)
        layout = [(mesh.vertices.buffer, "3f 1x4 3f 1x4 4f", "in_position", "in_normal", "in_tangent")]
        indices = mesh.indices if numbers is None else mesh.band_indices
        array = self.ctx.vertex_array(program.linked, layout, indices.buffer, 4)
        program.bind(
            vertex_data=mesh.vertices,
            corner_index=mesh.indices,
            triangle_number=mesh.numbers if numbers is None else mesh.band_numbers,
        )
        self.ctx.enable_only(moderngl.DEPTH_TEST)
        self.ctx.depth_func = "<"
        self.frames.depth_mask = True
        array.render(vertices=3 * len(mesh.mesh.triangles if numbers is None else numbers))
        array.release()
        self.ctx.enable_only(moderngl.NOTHING)
        self.frames.scissor = None  # type: ignore[assignment]

    def cut(self, later: GBuffer) -> None:
        """Uncover the pixels that another G-buffer, drawn after this one, covers."""
        self.drawings += 1
        program = programs(self.ctx).screen("passes/picture/cut.frag")
        draw_screen(program, self.frames, depth="written", later_N=later.frame("frame_N"))

    @property
    def drawn(self) -> Drawn | None:
        """What the frames hold."""
        return self._drawn

    def forget(self) -> None:
        """Draw anew at the next call, whatever the frames hold."""
        self._drawn = None

    # -- shading -----------------------------------------------------------------------------------------------------

    def frame(self, name: str) -> moderngl.Texture:
        """One of the textures that passes/picture/surface.frag fills, by its name there."""
        return self._textures[name]

    def inputs(self) -> dict[str, Any]:
        """What inputs/picture/gbuffer.glsl and gbuffer_point.glsl read."""
        return {**self._textures, "ray_from_pixel": self.ray_from_pixel}

    def defines(self) -> dict[str, int]:
        """Constants of the programs that shade it."""
        return {"PARTS": 1} if self.parts else {}

    def shade(
        self,
        program: Draw | Compute,
        *inputs: Inputs,
        add: bool = False,
        rows: tuple[int, int] | None = None,
        part: bool | None = None,
        onto: moderngl.Framebuffer | None = None,
    ) -> None:
        """Run a program of `covered.shading` for every covered pixel; `add` its colour instead of setting it.

        `rows` = (first, count), counted from below, limits it to a band of the picture; `part`: only the pixels of this one,
        which was asked for by `part`; `onto`: another picture with the same depth.
        """
        target = onto or self.target
        key: tuple[int, Any] = (self.drawings, None)
        if part is not None:
            _, target, chosen = self._some[part]
            key = self.drawings, chosen.key
        if part not in self._covered:
            self._covered[part] = Covered(self.ctx)
        self._covered[part].shade(program, target, self.inputs(), *inputs, key=key, add=add, rows=rows)

    def part(self, which: bool, choose: Callable[[moderngl.Framebuffer], None], *key: Any) -> moderngl.Framebuffer:
        """The picture with a depth of its own, one of two, that covers some of the pixels: `choose` writes it where the
        key changes."""
        if which not in self._some:
            depth = depth_texture(self.ctx, self.size)
            self._some[which] = depth, self.ctx.framebuffer([self.color, *self.parts], depth), Last()
        _, target, chosen = self._some[which]
        chosen.get(lambda: choose(target), *key)
        return target

    def choose(self, target: moderngl.Framebuffer, program: Draw, *inputs: Inputs) -> None:
        """Write the depth of a part of the pixels by a program."""
        target.color_mask = _masks(target, False)
        draw_screen(program, target, self.inputs(), *inputs, depth="written")
        target.color_mask = _masks(target, True)

    def read(self) -> np.ndarray:
        """The shaded picture, float32 [H, W, 4], top row first; alpha 1 where covered."""
        data = np.frombuffer(read_texture(self.color), "f4").reshape(self.size[1], self.size[0], 4)
        return data[::-1].copy()

    def covered(self) -> np.ndarray:
        """bool [H, W], top row first: which pixels see the mesh."""
        data = np.frombuffer(read_texture(self.frame("frame_N")), "f4").reshape(self.size[1], self.size[0], 4)
        return data[::-1, :, 3] != 0.0

    def release(self) -> None:
        """Free the GPU's memory."""
        # moderngl binds the last framebuffer back after making a new one; it must not be one of those deleted here.
        self.ctx.detect_framebuffer(0).use()
        own = [self.color] if self._owns_color else []
        for framebuffer in (self.frames, self.target, *(target for _, target, _ in self._some.values())):
            framebuffer.release()
        for covered in self._covered.values():
            covered.release()
        parts = [depth for depth, *_ in self._some.values()]
        for texture in (*self._textures.values(), self.depth, *own, *parts):
            texture.release()


def _cut_out(program: Draw, wanted: Drawn) -> Draw:
    """Give a program the maps of a mesh that has some; each sample has a threshold of its own, one alone a half."""
    if (cut := wanted.mesh.cut_out) is not None:
        openings = {}
        if "opacity_map" in cut.maps:
            openings = {"opacity_threshold": max((0.5 + sum(wanted.offset)) % 1.0, 1e-3)}
        program.bind(cut_uv=cut.uv, **cut.maps, **openings)
    return program


def _masks(target: moderngl.Framebuffer, written: bool) -> tuple:
    """Masks of all colours of a framebuffer, as moderngl takes them."""
    one = (written,) * 4
    count = len(target.color_attachments)
    return one if count == 1 else (one,) * count


def depth_texture(ctx: moderngl.Context, size: tuple[int, int]) -> moderngl.Texture:
    """A depth texture that shaders read as a number."""
    depth = ctx.depth_texture(size)
    depth.compare_func = ""
    depth.filter = moderngl.NEAREST, moderngl.NEAREST
    return depth


class DepthOrder:
    """The depth of what is nearest so far, while several surfaces are drawn one after the other."""

    def __init__(self, ctx: moderngl.Context, size: tuple[int, int]):
        self.ctx = ctx
        self.nearest = depth_texture(ctx, size)
        self._target = ctx.framebuffer([], self.nearest)

    def clear(self) -> None:
        """Nothing is there yet."""
        self._target.use()
        self._target.depth_mask = True
        self._target.clear(depth=1.0)

    def add(self, buffer: GBuffer) -> None:
        """Take the depth of a surface that was drawn."""
        program = programs(self.ctx).screen("passes/picture/nearest.frag")
        draw_screen(program, self._target, {"depth": buffer.depth}, depth="nearest")

    def release(self) -> None:
        """Free the GPU's memory."""
        self.ctx.detect_framebuffer(0).use()
        self._target.release()
        self.nearest.release()
