"""The objects and the ground as a surface, lit as Lambertians, or with gloss where an object says so.   [own, docs/shadows.md]"""

from __future__ import annotations

from typing import Any

import moderngl
import numpy as np

from ..color import luminance
from ..geometry.camera import Camera
from ..geometry.mesh import Mesh
from ..geometry.props import Objects
from ..gpu.buffers import TextureBuffer
from ..gpu.covered import shading
from ..gpu.gbuffer import GBuffer, MeshBuffers
from ..gpu.memo import Last
from ..twins.lambert import gaussian_irradiance
from ..visibility.hit_vertices import HitSurface
from ..visibility.irradiance import irradiance_table
from ..visibility.pixels import PixelView
from ..visibility.probes import subdivided
from ..visibility.vertices import COSINE
from .cloth import ClothSurface
from .frame import Frame
from .looks import Looks
from .surface import Surface

FADE = 1.5, 4.0  # of its scale: from where to where the shadow on a ground fades out that shows nothing else
NEAREST = 0.3  # of the eye's height above the ground: nothing of the ground is nearer to the eye
EDGE_OFFSET = 0.05  # of a mesh's mean edge: how far rays that light a vertex start from it,
GROUND_OFFSET = 2e-4  # of its scale: from the ground, where nothing is curved


class Solids(Surface):
    """All objects and the ground of a frame in one mesh; the ground's triangles are the last and hide no light, for
    the structure knows the plane."""

    objects: Objects
    offsets: np.ndarray  # [V] how far from its vertices rays start
    hiding = 0  # triangles that hide light
    _hiding_vertices = 0

    def __init__(self, ctx: moderngl.Context):
        super().__init__(ctx, COSINE)
        self._shape: Objects | None = None
        self._vertex_reflectances: Last[np.ndarray] = Last()
        self._reflectance_data = TextureBuffer(ctx, 16)
        self._colors: Last[None] = Last()
        self._open_irradiance: Last[np.ndarray] = Last()
        self._looks = Looks(ctx)
        self._look: Last[None] = Last()

    def prepare(self, frame: Frame, lit_by: ClothSurface) -> None:
        """Take other objects or lights; cheap when they are the same, or differ in colour only.

        `lit_by`: the cloth whose method and lights light them.
        """
        assert frame.objects is not None
        self._lit_by = lit_by
        self._bounces = frame.scene.bounce
        self._lights = frame.lights
        if not frame.objects.same_shape(self._shape):
            self._shape = frame.objects
            self._take_shape(frame.objects)
        self.objects = frame.objects
        self._colors.get(lambda: self._reflectance_data.write(self.triangle_reflectances()), frame.objects)
        self._look.get(
            lambda: self._looks.take(self.objects, self._shares, self._uvs, len(self.mesh.triangles)), self.objects
        )
        self.pass_count = lit_by.pass_count if lit_by.method.lights_solids else 1

    def _take_shape(self, objects: Objects) -> None:
        uneven = objects.graded or (False,) * len(objects.meshes)
        fine = [mesh if cut else subdivided(mesh) for mesh, cut in zip(objects.meshes, uneven, strict=True)]
        self._shares = [len(a.triangles) // len(b.triangles) for a, b in zip(fine, objects.meshes, strict=True)]
        self._uvs = [np.zeros((len(mesh.positions), 2)) if mesh.uv is None else mesh.uv for mesh in fine]
        self.hiding = sum(len(mesh.triangles) for mesh in fine)
        self._hiding_vertices = sum(len(mesh.positions) for mesh in fine)
        offsets = [EDGE_OFFSET * _edge_at_vertices(mesh, own) for mesh, own in zip(fine, uneven, strict=True)]
        if (ground := objects.ground) is not None:
            fine.append(ground.mesh)
            self._uvs.append(np.zeros((len(ground.mesh.positions), 2)))
            offsets.append(np.full(len(ground.mesh.positions), GROUND_OFFSET * ground.scale))
        self.offsets = np.concatenate(offsets)
        self.original = _joined(fine)
        self._place(lambda: MeshBuffers(self.ctx, self.original, None, self.hiding), self.original)

    # -- its contract ------------------------------------------------------------------------------------------------

    @property
    def broad(self) -> None:
        return None

    @property
    def hit_surface(self) -> HitSurface:
        return HitSurface(self.original, self.original, self.offsets, self.hiding, self.objects.ground)

    def triangle_reflectances(self) -> np.ndarray:
        """Of every triangle [T, 4] float32; one row more for hits on the ground."""
        parts = [np.repeat(r, n, axis=0) for r, n in zip(self.objects.reflectances, self._shares, strict=True)]
        color = self.objects.ground.color if self.objects.ground else (0.0, 0.0, 0.0)
        rows = np.zeros((len(self.mesh.triangles) + 1, 4), "f4")
        rows[:, :3] = np.concatenate([*parts, np.tile(color, (len(rows) - self.hiding, 1))])
        return rows

    @property
    def reflectance(self) -> np.ndarray:
        """Of every vertex [V, 4] float32: the mean of the triangles about it."""
        return self._vertex_reflectances.get(self._mean_reflectances, self.objects)

    def _mean_reflectances(self) -> np.ndarray:
        corners, colors = self.mesh.triangles, self.triangle_reflectances()[: len(self.mesh.triangles)]
        rows = np.zeros((len(self.mesh.positions), 4))
        for k in range(3):
            np.add.at(rows, corners[:, k], colors + np.array([0, 0, 0, 1], "f4"))
        return (rows / np.maximum(rows[:, 3:], 1.0)).astype("f4")

    def depth_range(self, camera: Camera) -> tuple[float, float]:
        ranges = []
        if self.hiding:
            used = self.mesh.positions[: self._hiding_vertices]
            near, far = camera.depth_range(used.min(0), used.max(0))
            if any(self.objects.graded):  # a floor below the camera: its box says nothing of how near it is
                at = self.mesh.positions[self.mesh.triangles[: self.hiding]]
                apart = np.maximum(np.maximum(at.min(1) - camera.eye, camera.eye - at.max(1)), 0.0)
                near = min(near, max(NEAREST * float(np.linalg.norm(apart, axis=1).min()), 1e-6 * far))
            ranges.append((near, far))
        if (ground := self.objects.ground) is not None and camera.ortho is not None:
            ranges.append(_ground_range(camera, ground.height, float(ground.radii[-1])))
        elif ground is not None:
            across = np.hypot(camera.eye[0] - ground.center[0], camera.eye[2] - ground.center[1])
            height = abs(camera.eye[1] - ground.height)
            ranges.append((NEAREST * height, 1.01 * float(np.hypot(across + ground.radii[-1], height))))
        return min(near for near, _ in ranges), max(far for _, far in ranges)

    @property
    def shown_triangles(self) -> int:
        return self.hiding if self.catches else len(self.mesh.triangles)

    def albedo_at(self, triangles: np.ndarray, uv: np.ndarray) -> np.ndarray:
        return self.triangle_reflectances()[triangles, :3]

    def identities(self, frame: Frame, number: int) -> list[tuple[int, str, str]]:
        own = [cloth.mesh.name for cloth in frame.cloths]
        names: list[str] = []
        for mesh in self.objects.meshes:
            own.append(mesh.name)
            before = own.count(mesh.name)
            names.append(mesh.name if before == 1 else f"{mesh.name}.{before}")
        counts = [len(mesh.triangles) * share for mesh, share in zip(self.objects.meshes, self._shares, strict=True)]
        if self.catches:  # a thing of the picture behind it
            return [(end, name, name) for end, name in zip(np.cumsum(counts).tolist(), names, strict=True)]
        ends = [*np.cumsum(counts).tolist(), len(self.mesh.triangles)]
        return [(end, name, name) for end, name in zip(ends, [*names, "ground"], strict=True)]

    # -- shading -----------------------------------------------------------------------------------------------------

    def shade(
        self, buffer: GBuffer, view: PixelView, number: int, weight: float, add: bool, rows: tuple[int, int] | None
    ) -> None:
        if number >= self.pass_count:
            return
        method = self._lit_by.method
        defines = {**buffer.defines(), **({"CATCHER": 1} if self.catches else {})}
        glossy = self._looks.glossy
        file = "inputs/picture/shade_object.glsl" if glossy else "inputs/picture/shade_lambert.glsl"
        if method.lights_solids:
            virtual, light = method.solids_includes(), {**method.inputs(), **self._lit_by.passes[number]}
            defines = {**method.defines(), **defines}
        else:
            virtual, light = {"lit.glsl": "inputs/visibility/lit_means.glsl"}, self._means(view)
        program = shading(self.ctx, file, defines, virtual, self.way)
        share = {"pass_weight": weight, "pass_cover": 0.0 if number else weight, **self._catcher()}
        look = self._looks.inputs(buffer, self.buffers) if glossy else {}
        buffer.shade(program, light, {"reflectance_data": self._reflectance_data, **look}, share, add=add, rows=rows)

    @property
    def catches(self) -> bool:
        """Whether of the ground only the shadow is seen."""
        return self.objects.ground is not None and self.objects.ground.catcher

    def _catcher(self) -> dict[str, Any]:
        """What inputs/picture/shade_lambert.glsl reads for a ground that shows its shadow alone."""
        if not self.catches:
            return {}
        ground = self.objects.ground
        assert ground is not None
        method = self._lit_by.method
        E = (
            method.open_irradiance()
            if method.lights_solids
            else self._open_irradiance.get(self._sum_open, self._lights)
        )
        return {
            "first_catching": self.hiding,
            "catcher_middle": ground.center,
            "catcher_fade": tuple(share * ground.scale for share in FADE),
            "open_luminance": max(float(luminance(E)), 1e-30),
        }

    def _sum_open(self) -> np.ndarray:
        """Irradiance [3] of a ground from all lights."""
        gaussians, suns = self._lights.gaussians, self._lights.suns
        E = (gaussian_irradiance(gaussians.sharpness, gaussians.axis[:, 1])[:, None] * gaussians.amplitude).sum(0)
        return E + (np.maximum(suns.direction[:, 1:2], 0.0) * suns.irradiance).sum(0)

    def _means(self, view: PixelView) -> dict[str, Any]:
        """Gaussians and suns, each as far as it is seen, and the bounced light."""
        mode = self.visibility.mode
        return {
            **self._lit_by.scene_buffers.inputs(),
            **irradiance_table(self.ctx, self._lights),
            **({} if mode == "off" else view.inputs()),
            "everything": mode == "off",
            "bounces": mode == "full" and self._bounces,
        }


def _ground_range(camera: Camera, height: float, radius: float) -> tuple[float, float]:
    """Near and far distance of a ground that parallel rays meet."""
    toward = camera.ray_from_pixel((2, 1))[:, 2]
    origins = camera.origin_from_pixel((2, 1)) @ np.array([[x, y, 1.0] for x in (0, 2) for y in (0, 1)]).T
    if toward[1] > -1e-6:
        return np.inf, 0.0  # none does
    t = (height - origins[1]) / toward[1]
    far = max(min(1.05 * float(t.max()), 2.0 * (radius + camera.reach)), 1e-6)
    return max(0.95 * float(t.min()), 1e-3 * far), far


def _edge_at_vertices(mesh: Mesh, own: bool) -> np.ndarray:
    """The mean edge of a mesh, or of each vertex its own, [V]."""
    count = len(mesh.positions)
    if not own:
        return np.full(count, mesh.mean_edge)
    a, b = mesh.edges().T
    length = np.linalg.norm(mesh.positions[a].astype(float) - mesh.positions[b], axis=1)
    total = np.bincount(a, length, count) + np.bincount(b, length, count)
    return total / np.maximum(np.bincount(a, minlength=count) + np.bincount(b, minlength=count), 1)


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
