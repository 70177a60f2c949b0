"""The G-buffer: which surface frame every pixel sees, and the camera rays that go with it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import moderngl
import numpy as np

from ..geometry.camera import Camera
from ..geometry.mesh import Mesh
from . import shader
from .buffers import TextureBuffer

FRAME_UNITS = (3, 4)  # texture units of frame_N and frame_x, as inputs/picture/gbuffer.glsl declares them
NEARER_UNIT = 8  # of the depth that others left, in surface.frag
POINT_UNITS = (
    6,
    7,
)  # of frame_p and frame_b, as inputs/picture/gbuffer_point.glsl declares them; of the mesh in surface.frag
NUMBER_UNIT = 5  # of the triangles' numbers in surface.frag
VERTEX_TEXELS = 3  # position, normal, tangent


class MeshBuffers:
    """One mesh on the GPU, to be drawn and to be fetched from: `vertices` has VERTEX_TEXELS for each, `indices` three
    texels a triangle."""

    def __init__(self, ctx: moderngl.Context, mesh: Mesh, lift: np.ndarray | None = None):
        """`lift` [V, 2]: how far in front and behind the surface that hides light lies below the curved one, where it is
        coarser than the mesh."""
        self.mesh = mesh
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
        for thing in (self.vertices, self.indices, self.numbers, self.band_indices, self.band_numbers):
            thing.release()


@dataclass(frozen=True)
class Among:
    """How a mesh is drawn together with others, each into a G-buffer of its own.

    Parameters
    ----------
    depths : near and far distance for all of them
    nearer : what stands before the mesh hides it; None: this is drawn first
    state : what `nearer` holds
    first_of_ground : from this triangle on only the front is drawn
    """

    depths: tuple[float, float]
    nearer: GBuffer | None = None
    state: tuple | None = None
    first_of_ground: int = 1 << 30


class GBuffer:
    """Frames and depth of one view; `shade` runs a program for each covered pixel, hidden ones cost nothing."""

    def __init__(self, ctx: moderngl.Context, size: tuple[int, int], program: moderngl.Program | None = None):
        """`program`: that of another G-buffer, so that a second size compiles nothing."""
        self.ctx, self.size = ctx, size
        self.frame_N = ctx.texture(size, 4, dtype="f4")
        self.frame_x = ctx.texture(size, 4, dtype="f4")
        self.frame_p = ctx.texture(size, 4, dtype="f4")
        self.frame_b = ctx.texture(size, 2, dtype="f4")
        self.color = ctx.texture(size, 4, dtype="f4")
        for texture in (self.frame_N, self.frame_x, self.frame_p, self.frame_b, self.color):
            texture.filter = moderngl.NEAREST, moderngl.NEAREST
        self.depth = ctx.depth_texture(size)
        self.depth.compare_func = ""  # read as a number, where another mesh is drawn after this one
        self.depth.filter = moderngl.NEAREST, moderngl.NEAREST
        self.frames = ctx.framebuffer([self.frame_N, self.frame_x, self.frame_p, self.frame_b], self.depth)
        self.target = ctx.framebuffer([self.color], self.depth)
        self.program = program or shader.program(ctx, "passes/picture/surface.vert", "passes/picture/surface.frag")
        self._among_program = None
        self.released = False
        self.ray_from_pixel = np.eye(3)
        self._drawn: tuple | None = None

    def draw(self, mesh: MeshBuffers, camera: Camera, offset=(0.0, 0.0), among: Among | None = None) -> None:
        """Fill the frames and the depth with one mesh, seen by `camera`, each pixel sampled at its centre + `offset`.

        `among`: how it is drawn together with others. Does nothing when they hold just that: an edit of fabric or light
        moves no pixel.
        """
        for _ in self.draw_bands(mesh, camera, offset, self.size[1], among):
            pass

    def draw_bands(
        self, mesh: MeshBuffers, camera: Camera, offset, rows: int, among: Among | None = None
    ) -> Iterator[None]:
        """As `draw`, so many rows at a time, for a caller with other things to do in between."""
        if self._drawn == (mesh, camera, offset, among):
            return
        self._drawn = None
        near, far = camera.depth_range(mesh.low, mesh.high) if among is None else among.depths
        clip = camera.clip_from_world(self.size, near, far, offset)
        self.ray_from_pixel = camera.ray_from_pixel(self.size, offset)
        height = self.size[1]
        if rows < height:
            low, high = mesh.heights(clip)
        for first in range(0, height, rows):
            numbers = None
            if rows < height:
                # A pixel more to either side, for the rasteriser rounds as it likes.
                below, above = (2.0 * (y / height) - 1.0 for y in (first - 1, first + rows + 1))
                numbers = np.flatnonzero((high >= below) & (low <= above))
            band = (0, first, self.size[0], min(rows, height - first))
            self._draw_band(mesh, clip, camera.eye, band, numbers, among)
            yield
        self._drawn = mesh, camera, offset, among

    def _draw_band(self, mesh: MeshBuffers, clip, eye, band: tuple[int, int, int, int], numbers, among) -> None:
        """Draw all triangles, or those of `numbers`, into a band of the frames."""
        self.frames.scissor = None if numbers is None else band
        self.frames.use()
        self.frames.viewport = (0, 0, *self.size)
        self.frames.clear(0.0, 0.0, 0.0, 0.0, depth=1.0, viewport=None if numbers is None else band)
        if numbers is not None:
            if not len(numbers):
                self.frames.scissor = None
                return
            mesh.choose(numbers)
        program = self.program if among is None else self._program_among(among)
        program["clip_from_world"].write(clip.T.astype("f4").tobytes())
        program["eye"].value = eye
        layout = [(mesh.vertices.buffer, "3f 1x4 3f 1x4 4f", "in_position", "in_normal", "in_tangent")]
        indices = mesh.indices if numbers is None else mesh.band_indices
        array = self.ctx.vertex_array(program, layout, indices.buffer, 4)
        mesh.vertices.bind(POINT_UNITS[0])
        mesh.indices.bind(POINT_UNITS[1])
        (mesh.numbers if numbers is None else mesh.band_numbers).bind(NUMBER_UNIT)
        self.ctx.enable_only(moderngl.DEPTH_TEST)
        self.ctx.depth_func = "<"
        self.frames.depth_mask = True
        array.render(vertices=3 * len(mesh.mesh.triangles if numbers is None else numbers))
        array.release()
        self.frames.scissor = None

    def _program_among(self, among: Among):
        """The program that draws a mesh among others, ready for it; compiled at first use."""
        if self._among_program is None:
            defines = {"AMONG_OTHERS": 1}
            self._among_program = shader.program(
                self.ctx, "passes/picture/surface.vert", "passes/picture/surface.frag", defines
            )
        shader.set_uniforms(
            self._among_program, first_of_ground=among.first_of_ground, hidden_by_others=among.nearer is not None
        )
        if among.nearer is not None:
            among.nearer.depth.use(NEARER_UNIT)
        return self._among_program

    def clear_color(self) -> None:
        """Black, alpha 0, everywhere."""
        self.target.use()
        self.target.color_mask = (True, True, True, True)
        self.target.depth_mask = False  # what `draw` left stays
        self.target.clear(0.0, 0.0, 0.0, 0.0)

    def bind(self, program) -> None:
        """Give a program that includes inputs/picture/gbuffer.glsl its frames and rays."""
        self.frame_N.use(FRAME_UNITS[0])
        self.frame_x.use(FRAME_UNITS[1])
        if "ray_from_pixel" in program:
            program["ray_from_pixel"].write(self.ray_from_pixel.T.astype("f4").tobytes())
        if "frame_p" in program:
            self.bind_points(program)

    def inputs(self) -> dict:
        """What inputs/picture/gbuffer.glsl and inputs/picture/gbuffer_point.glsl read."""
        frames = {"frame_N": self.frame_N, "frame_x": self.frame_x, "frame_p": self.frame_p, "frame_b": self.frame_b}
        return frames | {"ray_from_pixel": self.ray_from_pixel}

    def bind_points(self, program) -> None:
        """Give a program that includes inputs/picture/gbuffer_point.glsl the point and the triangle that each pixel sees."""
        self.frame_p.use(POINT_UNITS[0])
        self.frame_b.use(POINT_UNITS[1])

    @property
    def drawn(self) -> tuple | None:
        """What the frames hold: the mesh's buffers, the camera and the place in the pixel."""
        return self._drawn

    def shade(self, program, add: bool = False, rows: tuple[int, int] | None = None) -> None:
        """Run a program of passes/picture/screen.vert for every covered pixel; `add` its colour instead of setting it.

        `rows` = (first, count), counted from below, limits it to a band of the picture.

        The screen triangle lies on the far plane and passes where something nearer was drawn, so early depth testing
        drops uncovered pixels before they are shaded.
        """
        self.bind(program)
        self.target.scissor = None if rows is None else (0, rows[0], self.size[0], rows[1])
        self.target.use()
        self.target.viewport = (0, 0, *self.size)
        self.target.depth_mask = False
        self.ctx.enable_only(moderngl.DEPTH_TEST | (moderngl.BLEND if add else 0))
        self.ctx.depth_func = ">"
        if add:
            self.ctx.blend_func = moderngl.ONE, moderngl.ONE
        array = self.ctx.vertex_array(program, [])
        array.render(moderngl.TRIANGLES, vertices=3)
        array.release()
        self.ctx.depth_func = "<"
        self.ctx.enable_only(moderngl.NOTHING)
        if rows is not None:
            self.target.scissor = None

    def fill_behind(self, program, target: moderngl.Framebuffer | None = None) -> None:
        """Run a program over the whole screen, behind what was shaded: weighted by what the cloth leaves uncovered.

        `target`: another framebuffer of the same size to fill instead of the colour target.
        """
        if "ray_from_pixel" in program:
            program["ray_from_pixel"].write(self.ray_from_pixel.T.astype("f4").tobytes())
        (target or self.target).use()
        self.ctx.enable_only(moderngl.BLEND)
        self.ctx.blend_func = moderngl.ONE_MINUS_DST_ALPHA, moderngl.ONE
        array = self.ctx.vertex_array(program, [])
        array.render(moderngl.TRIANGLES, vertices=3)
        array.release()
        self.ctx.enable_only(moderngl.NOTHING)

    def read(self) -> np.ndarray:
        """The shaded picture, float32 [H, W, 4], top row first; alpha 1 where covered."""
        data = np.frombuffer(self.color.read(), "f4").reshape(self.size[1], self.size[0], 4)
        return data[::-1].copy()

    def covered(self) -> np.ndarray:
        """bool [H, W], top row first: which pixels see the mesh."""
        data = np.frombuffer(self.frame_N.read(), "f4").reshape(self.size[1], self.size[0], 4)
        return data[::-1, :, 3] != 0.0

    def release(self) -> None:
        self.released = True
        # moderngl binds the last framebuffer back after making a new one; it must not be one of those deleted here.
        self.ctx.detect_framebuffer(0).use()
        for thing in (
            self.frames,
            self.target,
            self.frame_N,
            self.frame_x,
            self.frame_p,
            self.frame_b,
            self.color,
            self.depth,
        ):
            thing.release()
