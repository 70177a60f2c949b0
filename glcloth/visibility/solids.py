"""What stands about the cloth, on the GPU: drawn, hidden and hiding, and lit as Lambertians.   [own, docs/shadows.md]"""

from __future__ import annotations

from collections.abc import Iterator

import moderngl
import numpy as np

from ..geometry.camera import Camera
from ..geometry.mesh import Mesh
from ..geometry.props import Objects
from ..gpu import shader
from ..gpu.buffers import TextureBuffer
from ..gpu.gbuffer import Among, GBuffer, MeshBuffers
from ..light.lights import Lights
from ..settings import ShadowMode
from .hit_vertices import HitSurface
from .irradiance import irradiance_table
from .pixels import Occluders, PixelView, PixelVisibility, bind_numbered
from .probes import subdivided
from .vertices import COSINE

NEAREST = 0.3  # of the eye's height above the ground: nothing of the ground is nearer to the eye
EDGE_OFFSET = 0.05  # of a mesh's mean edge: how far rays that light a vertex start from it,
GROUND_OFFSET = 2e-4  # of its scale: from the ground, where nothing is curved
TABLE_UNIT, REFLECTANCE_UNIT, CLOTH_UNIT = 12, 14, 5


class Around:
    """Objects and ground of one cloth, lit by the same lights, with the cloth's shadow on them.

    `prepare` takes the objects, `triangles` and `mesh` are what hides light of them (the ground needs no triangles),
    `draw_bands` draws them, before the cloth; `shade` lights them where they are seen.
    """

    def __init__(self, ctx: moderngl.Context):
        self.ctx = ctx
        self.shadows = PixelVisibility(ctx, COSINE)
        self.objects: Objects | None = None
        self.mesh: Mesh | None = None
        self.buffers: MeshBuffers | None = None
        self.solid = 0  # triangles of objects; the ground's follow
        self.solid_vertices = 0
        self._reflectances = TextureBuffer(ctx, 16)
        self._programs: dict[tuple, object] = {}
        self._targets: dict[GBuffer, tuple[GBuffer, moderngl.Framebuffer]] = {}

    def prepare(self, objects: Objects) -> None:
        """Take other objects; cheap when they are the same, or differ in colour only."""
        if objects is self.objects:
            return
        if not objects.same_shape(self.objects):
            fine = [subdivided(mesh) for mesh in objects.meshes]
            self._shares = [len(a.triangles) // len(b.triangles) for a, b in zip(fine, objects.meshes, strict=True)]
            self.solid = sum(len(mesh.triangles) for mesh in fine)
            self.solid_vertices = sum(len(mesh.positions) for mesh in fine)
            parts = fine + ([objects.ground.mesh] if objects.ground else [])
            self.mesh = _joined(parts)
            if self.buffers is not None:
                self.buffers.release()
            self.buffers = MeshBuffers(self.ctx, self.mesh)
            self.offsets = np.concatenate([_offsets(mesh) for mesh in fine] + [np.zeros(0)])
            if objects.ground:
                off = np.full(len(parts[-1].positions), GROUND_OFFSET * objects.ground.scale)
                self.offsets = np.concatenate([self.offsets, off])
        self.objects = objects
        self._reflectances.write(self.reflectances())
        self.vertex_reflectances = self._vertex_reflectances()

    def reflectances(self) -> np.ndarray:
        """Of every triangle [T, 4] float32; one row more for what is met of the ground."""
        parts = [np.repeat(r, n, axis=0) for r, n in zip(self.objects.reflectances, self._shares, strict=True)]
        color = self.objects.ground.color if self.objects.ground else (0.0, 0.0, 0.0)
        rows = np.zeros((len(self.mesh.triangles) + 1, 4), "f4")
        rows[:, :3] = np.concatenate([*parts, np.tile(color, (len(rows) - self.solid, 1))])
        return rows

    def _vertex_reflectances(self) -> np.ndarray:
        """Of every vertex [V, 4] float32: the mean of the triangles about it."""
        corners, colors = self.mesh.triangles, self.reflectances()[: len(self.mesh.triangles)]
        rows = np.zeros((len(self.mesh.positions), 4))
        for k in range(3):
            np.add.at(rows, corners[:, k], colors + np.float32([0, 0, 0, 1]))
        return (rows / np.maximum(rows[:, 3:], 1.0)).astype("f4")

    @property
    def triangles(self) -> np.ndarray:
        """The corners [T, 3, 3] of what hides light, but for the ground."""
        return self.mesh.positions[self.mesh.triangles[: self.solid]]

    @property
    def hit_surface(self) -> HitSurface:
        """Where rays can end on these."""
        return HitSurface(self.mesh, self.mesh, self.offsets, self.solid, self.objects.ground)

    # -- drawing -----------------------------------------------------------------------------------------------------

    def draw_bands(self, buffer: GBuffer, cloth: MeshBuffers, camera: Camera, offset, rows: int) -> Iterator[None]:
        """Draw the objects into a G-buffer beside the cloth's, so many rows at a time."""
        beside, _ = self._target(buffer)
        among = Among(self._depths(cloth, camera), first_of_ground=self.solid)
        yield from beside.draw_bands(self.buffers, camera, offset, rows, among)

    def among(self, buffer: GBuffer) -> Among:
        """How the cloth is drawn after the objects."""
        beside, _ = self._target(buffer)
        return Among(beside.drawn[3].depths, beside, beside.drawn)

    def beside(self, buffer: GBuffer) -> GBuffer:
        """The G-buffer of the objects beside that of the cloth."""
        return self._target(buffer)[0]

    def _target(self, buffer: GBuffer) -> tuple[GBuffer, moderngl.Framebuffer]:
        """The G-buffer beside a cloth's, and what draws into the cloth's picture where the objects are."""
        if buffer not in self._targets:
            program = next((g.program for g, _ in self._targets.values()), None)
            for key in [key for key in self._targets if key.released]:
                beside, framebuffer = self._targets.pop(key)
                self.ctx.detect_framebuffer(0).use()
                framebuffer.release()
                beside.release()
            beside = GBuffer(self.ctx, buffer.size, program or buffer.program)
            self._targets[buffer] = beside, self.ctx.framebuffer([buffer.color], beside.depth)
        return self._targets[buffer]

    def _depths(self, cloth: MeshBuffers, camera: Camera) -> tuple[float, float]:
        """Near and far distance of all there is."""
        ground = self.objects.ground
        boxes = [(cloth.low, cloth.high)]
        if self.solid:
            used = self.mesh.positions[: self.solid_vertices]
            boxes.append((used.min(0), used.max(0)))
        depths = [camera.depth_range(low, high) for low, high in boxes]
        near, far = min(d[0] for d in depths), max(d[1] for d in depths)
        if ground:
            across = np.hypot(camera.eye[0] - ground.center[0], camera.eye[2] - ground.center[1])
            height = abs(camera.eye[1] - ground.height)
            far = max(far, 1.01 * float(np.hypot(across + ground.radii[-1], height)))
            near = max(min(near, NEAREST * height), 1e-5 * far)
        return near, far

    # -- light -------------------------------------------------------------------------------------------------------

    def look_out(self, mode: ShadowMode, structure, lights: Lights, bounce: bool, occluders: Occluders) -> None:
        """Choose what hides what, as `PixelVisibility.prepare`; nothing is traced yet."""
        self.shadows.prepare(mode, self.mesh, self.mesh, structure, lights, bounce, occluders)
        self._mode = mode

    def lit_by_means(self, lights: Lights, shared, view: PixelView | None):
        """The program that shades by Gaussians and suns, each as far as a view finds it seen, ready to `run`; `shared` has
        the lights."""
        program = self.program("inputs/visibility/lit_means.glsl")
        shared.bind(program)
        irradiance_table(self.ctx, lights)["irradiance_table"].bind(TABLE_UNIT)
        if view is not None:
            bind_numbered(program, view.inputs())
        shader.set_uniforms(program, everything=self._mode == "off")
        return program

    def bind(self, program) -> None:
        """Bind the reflectances of the triangles."""
        self._reflectances.bind(REFLECTANCE_UNIT)
        shader.set_uniforms(program, first_of_ground=self.solid)

    def run(self, buffer: GBuffer, program, weight: float, cover: float, rows: tuple[int, int] | None = None) -> None:
        """Add what a program of passes/picture/lambert.frag makes of the pixels that see the objects to the cloth's picture.

        Parameters
        ----------
        weight, cover : of this sample in a pixel's radiance and coverage
        rows : (first, count), counted from below: only these
        """
        beside, target = self._target(buffer)
        self._reflectances.bind(REFLECTANCE_UNIT)
        buffer.frame_N.use(CLOTH_UNIT)
        shader.set_uniforms(program, pass_weight=weight, pass_cover=cover)
        beside.bind(program)
        beside.bind_points(program)
        target.scissor = None if rows is None else (0, rows[0], beside.size[0], rows[1])
        target.use()
        target.viewport = (0, 0, *beside.size)
        target.depth_mask = False
        self.ctx.enable_only(moderngl.DEPTH_TEST | moderngl.BLEND)
        self.ctx.blend_func = moderngl.ONE, moderngl.ONE
        self.ctx.depth_func = ">"
        array = self.ctx.vertex_array(program, [])
        array.render(moderngl.TRIANGLES, vertices=3)
        array.release()
        self.ctx.depth_func = "<"
        self.ctx.enable_only(moderngl.NOTHING)
        target.scissor = None

    def program(self, lit: str, defines: dict | None = None, virtual: dict | None = None):
        """The program of passes/picture/lambert.frag that gets its light from a pass file, compiled at first use."""
        key = lit, *(defines or {}), *(virtual or {}).values()
        if key not in self._programs:
            virtual = {"lit.glsl": lit, **(virtual or {})}
            self._programs[key] = shader.program(
                self.ctx, "passes/picture/screen.vert", "passes/picture/lambert.frag", defines, virtual
            )
        return self._programs[key]


def _offsets(mesh: Mesh) -> np.ndarray:
    """How far [V] off the vertices of an object rays start."""
    corners = mesh.positions[mesh.triangles].astype(float)
    edge = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).mean()
    return np.full(len(mesh.positions), EDGE_OFFSET * edge)


def _joined(meshes: list[Mesh]) -> Mesh:
    """Several meshes as one, in their order."""
    begins = np.cumsum([0] + [len(mesh.positions) for mesh in meshes])
    return Mesh(
        "objects",
        np.concatenate([mesh.positions for mesh in meshes]),
        np.concatenate([mesh.triangles + begin for mesh, begin in zip(meshes, begins, strict=False)]),
        np.concatenate([mesh.normals for mesh in meshes]),
        None,
        np.concatenate([mesh.tangents for mesh in meshes]),
    )
