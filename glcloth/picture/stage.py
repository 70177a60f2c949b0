"""The surfaces of a frame on the GPU, and the structure of all that hides light from them."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace

import moderngl
import numpy as np

from ..accel.ground import OverGround
from ..accel.structure import Structure, Traced, make_structure
from ..accel.triangles import Triangles
from ..gpu.buffers import TextureBuffer
from ..gpu.memo import Last
from ..methods.method import Geometry
from ..scene import ShadowMode
from ..visibility.bounce import Bounce
from ..visibility.finer import FinerTriangles, SunOccluders, cuts
from ..visibility.pixels import Occluders
from ..visibility.sheets import Sheets
from .cloth import ClothSurface
from .frame import Frame
from .pace import Pace
from .solids import Solids
from .surface import Surface
from .target import Target

OCCLUDER_STRUCTURE = "lbvh"  # any-hit rays of the built-in cloth: as fast as the kd-tree; built five times as fast


def shadow_mode(frame: Frame) -> ShadowMode:
    """The mode of shadows that vertices and pixels trace; the reference traces its own."""
    scene = frame.scene
    if scene.method == "reference" or (scene.shadows == "sun" and not len(frame.lights.suns)):
        return "off"
    return scene.shadows


class Stage:
    """Keeps the surfaces from frame to frame, so that nothing unchanged is made again."""

    def __init__(self, ctx: moderngl.Context):
        self.ctx = ctx
        self.cloths = [ClothSurface(ctx)]
        self.cloths_in_frame: list[ClothSurface] = []  # of the last frame
        self.surfaces: list[Surface] = []  # and the objects with them
        self._solids = Solids(ctx)
        self._bounce = Bounce(ctx)
        self._bounces = False
        self._sheets = Sheets(ctx, self._bounce.hit_vertices)
        self._structure: Last[Traced] = Last()
        self._triangles: Triangles | None = None
        self._tree: Structure | None = None
        self._sun_occluders: Last[SunOccluders] = Last()
        self._sun_tree: Structure | None = None
        self._finer = FinerTriangles(ctx)
        self._reflectance_data = TextureBuffer(ctx, 16)  # of all surfaces but the first cloth

    def take(self, frame: Frame) -> list[Surface]:
        """Take a frame: returns its surfaces, ready to be drawn, to see and to be shaded."""
        mode = shadow_mode(frame)
        while len(self.cloths) < len(frame.cloths):
            self.cloths.append(ClothSurface(self.ctx))
        self.cloths_in_frame = self.cloths[: len(frame.cloths)]
        for surface, cloth in zip(self.cloths_in_frame, frame.cloths, strict=True):
            surface.prepare(cloth, frame, mode == "full")
        self.surfaces = [*self.cloths_in_frame]
        if frame.objects is not None:
            self._solids.prepare(frame, self.cloths[0])
            self.surfaces.append(self._solids)
        self._bounces = mode == "full" and frame.scene.bounce
        self._look(frame, mode)
        return self.surfaces

    def _look(self, frame: Frame, mode: ShadowMode) -> None:
        """Give each surface its occluders; nothing is traced yet."""
        structure = self.occluders(frame) if mode != "off" else None
        hit_vertices = self._bounce.hit_vertices
        several = len(self.surfaces) > 1 or self._bounces
        sheets = self._sheets_of(structure)
        if structure is not None and several:
            hit_vertices.prepare([surface.hit_surface for surface in self.surfaces], structure.triangles)
        sun_occluders = None if structure is None else self.sun_occluders(frame)
        solids_see = sun_occluders and replace(sun_occluders, own=0)
        for surface in self.surfaces:
            occluders = None
            if structure is not None and several:
                others = tuple(other.original for other in self.surfaces if other is not surface)
                ground = frame.objects is not None and frame.objects.ground is not None
                occluders = Occluders(others, ground, hit_vertices)
            surface.visibility.prepare(
                *(mode, surface.mesh, surface.original, structure, frame.lights, frame.scene.bounce, occluders),
                sheets=sheets,
                sun_occluders=sun_occluders if surface is not self._solids else solids_see,
            )

    def _sheets_of(self, structure: Traced | None) -> Sheets | None:
        """The cloths as rays through a structure find them, where any lets light through."""
        transmissions = [cloth.transmission for cloth in self.cloths_in_frame]
        if structure is None or not any(transmissions):
            return None
        hit_vertices = self._bounce.hit_vertices
        hit_vertices.prepare([surface.hit_surface for surface in self.surfaces], structure.triangles)
        return self._sheets.prepare(transmissions)

    def occluders(self, frame: Frame) -> Traced:
        """The structure over all that hides light: the surfaces' triangles, one after the other, and the ground."""
        originals = tuple(surface.original for surface in self.surfaces)
        return self._structure.get(lambda: self._built(frame), originals)

    def _built(self, frame: Frame) -> Traced:
        hit = [surface.hit_surface for surface in self.surfaces]
        corners = np.concatenate([one.original.positions[one.original.triangles[: one.hiding]] for one in hit])
        if self._tree is None:
            self._tree = make_structure(self.ctx, OCCLUDER_STRUCTURE)
        if self._triangles is not None and self._triangles.count == len(corners):
            self._triangles.move(corners)
        else:
            if self._triangles is not None:
                self._triangles.release()
            self._triangles = Triangles.of(self.ctx, corners)
        self._tree.build(self._triangles)
        return self._over_ground(frame, self._tree)

    @staticmethod
    def _over_ground(frame: Frame, tree: Structure) -> Traced:
        ground = None if frame.objects is None else frame.objects.ground
        return tree if ground is None else OverGround(tree, ground.height)

    def sun_occluders(self, frame: Frame) -> SunOccluders | None:
        """What hides suns from pixels and from the reference; None where there are no suns."""
        if not len(frame.lights.suns):
            return None
        structure = self.occluders(frame)
        return self._sun_occluders.get(
            lambda: self._cut(frame, structure), structure, tuple(surface.original for surface in self.surfaces)
        )

    def _cut(self, frame: Frame, structure: Traced) -> SunOccluders:
        hit, coarse = self._bounce.hit_vertices, structure.triangles
        assert coarse is not None
        hit.prepare([surface.hit_surface for surface in self.surfaces], coarse)
        cloths = self.cloths_in_frame
        cut = hit.first_triangle[len(cloths)]
        levels = cuts([cloth.original for cloth in cloths], cut, coarse.count - cut)
        if not levels:
            return SunOccluders(structure)
        if self._sun_tree is None:
            self._sun_tree = make_structure(self.ctx, OCCLUDER_STRUCTURE)
        self._sun_tree.build(self._finer.cut(hit, coarse, cut, levels))
        return SunOccluders(self._over_ground(frame, self._sun_tree), levels, cut, levels)

    def follow_poses(self, follow: bool) -> None:
        """See `Renderer.follow_poses`."""
        for surface in (*self.cloths, self._solids):
            surface.visibility.follow_poses(follow)

    # -- the work of a frame before shading --------------------------------------------------------------------------

    def trace(self, count: int = 32, enough: int | None = None) -> Iterator[int]:
        """Trace the missing directions of all vertices; see `Renderer.trace_visibility`."""
        for surface in self.surfaces:
            yield from surface.visibility.steps(count, enough)

    def geometry_jobs(self, frame: Frame) -> list[Callable[[], None]]:
        """The jobs to run, in this order, for methods that cast rays as they shade."""
        traced = [cloth.method for cloth in self.cloths_in_frame if cloth.method.traced]
        if not traced:
            return []
        geometry = self._geometry(frame)
        jobs = [job for method in traced for job in method.set_geometry(geometry)]
        for cloth in self.cloths_in_frame:
            cloth.passes = list(cloth.method.passes())
        return jobs

    def _geometry(self, frame: Frame) -> Geometry:
        """The surfaces that rays meet, and the share of light that each reflects."""
        structure, hit_vertices = self.occluders(frame), self._bounce.hit_vertices
        hit_vertices.prepare([surface.hit_surface for surface in self.surfaces], structure.triangles)
        albedos = [cloth.method.albedo * cloth.visibility.limit for cloth in self.cloths_in_frame]
        reflectances = None
        if len(self.surfaces) > 1:
            others = zip(self.cloths_in_frame[1:], albedos[1:], strict=True)
            rows = [
                np.tile(np.append(albedo, 0.0), (len(cloth.original.triangles[: cloth.hit_surface.hiding]), 1))
                for cloth, albedo in others
            ]
            first_of_ground = sum(map(len, rows)) + (self._solids.hiding if frame.objects else 0)
            rows.append(self._solids.triangle_reflectances() if frame.objects else np.zeros((1, 4)))
            self._reflectance_data.write(np.concatenate(rows).astype("f4"))
            reflectances = {"reflectance_data": self._reflectance_data, "first_of_ground": first_of_ground}
        meshes = tuple(surface.mesh for surface in self.surfaces)
        sheets, suns = self._sheets_of(structure), self.sun_occluders(frame)
        return Geometry(structure, hit_vertices, meshes, albedos[0], reflectances, sheets, suns)

    def see(self, target: Target, frame: Frame, sample: tuple[int, int], pace: Pace) -> Iterator[None]:
        """Find how far the pixels see the lights, and each other."""
        if shadow_mode(frame) == "off":
            return
        parts = target.parts(self.surfaces)
        for surface, part in parts:
            yield from surface.see(part.view, sample, pace)
        if not self._bounces:
            return
        reflectances = [(s.visibility, s.reflectance, s.given) for s in self.surfaces]
        for _ in self._bounce.gather(reflectances, self.cloths[0].scene_buffers):
            yield from pace.pause(self.ctx)
        for _, part in parts:
            part.view.resolve_bounce()
        yield from pace.pause(self.ctx)

    def hairs_over(self, target: Target, frame: Frame) -> Iterator[None]:
        """Draw a frame's hairs over a picture of it that was not drawn by its surfaces."""
        surfaces = self.take(frame)
        for _ in self.trace():
            yield
        for _ in target.draw(surfaces, frame.camera, (0.0, 0.0), target.size[1]):
            yield
        for cloth in self.cloths_in_frame:
            cloth.visibility.integrate(cloth.broad)
        self.draw_hairs(target, frame)

    def draw_hairs(self, target: Target, frame: Frame) -> None:
        """Draw the hairs of cloth that stand out beyond its outline over the finished picture."""
        found = []
        for cloth in self.cloths_in_frame:
            buffer = target.part(cloth).buffer
            if (hairs := cloth.hairs(buffer, frame)) is not None:
                found.append((cloth, hairs, buffer))
        if not found:
            return
        nearest = target.nearest(self.surfaces)
        for cloth, hairs, buffer in found:
            cloth.draw_hairs(hairs, buffer, nearest, frame)
