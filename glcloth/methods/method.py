"""What a method must give the passes that draw: the contract of `direct`, `paper` and `reference`, with defaults."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

import moderngl
import numpy as np

from ..accel.structure import Traced
from ..fabric import Fabric
from ..geometry.mesh import Mesh
from ..gpu.buffers import Buffer
from ..gpu.programs import programs
from ..gpu.scene_buffers import SceneBuffers
from ..light.lights import Lights
from ..visibility.finer import SunOccluders
from ..visibility.hit_vertices import HitVertices
from ..visibility.sheets import Sheets
from .settings import Settings


@dataclass(frozen=True, eq=False)
class Geometry:
    """Where the surfaces of a frame are, for methods that cast rays.

    Parameters
    ----------
    structure : over the triangles of the surfaces, one after the other, and the ground
    hit_vertices : of the surfaces in that order
    meshes : of the surfaces; the same objects as long as nothing moves
    albedo : [3] of the first cloth
    reflectances : what inputs/visibility/reflectance.glsl reads of the others; None: there are none
    sheets : of the cloths, where any lets light through
    sun_occluders : what hides suns; None: there are none
    """

    structure: Traced
    hit_vertices: HitVertices
    meshes: tuple[Mesh, ...]
    albedo: np.ndarray
    reflectances: dict[str, Any] | None = None
    sheets: Sheets | None = None
    sun_occluders: SunOccluders | None = None

    @property
    def finer(self) -> dict[str, int]:
        """Defines, where the triangles that hide suns are finer."""
        return {} if self.sun_occluders is None else self.sun_occluders.defines()

    @property
    def several(self) -> bool:
        """Whether there is more to meet than one cloth."""
        return self.reflectances is not None

    def inputs(self) -> dict[str, Any]:
        """What inputs/visibility/along_ray.glsl reads, but for the irradiance of the vertices."""
        return {
            **self.structure.inputs(),
            **self.hit_vertices.inputs(),
            **(self.reflectances or {}),
            **(self.sheets.inputs() if self.sheets is not None else {}),
            "finer_levels": 0,
            "own_levels": 0,
            "cloth_triangles": self.hit_vertices.first_triangle[1],
            "radiance_per_irradiance": self.albedo / np.pi,
        }


class Method:
    """A way to find the radiance of cloth: a GLSL file with `L_o`, and what that file reads.

    `prepare` comes first. The other members then describe what was prepared: a program is made of `source`, `defines`
    and `includes`, given `inputs`, and run once for each of `passes`, whose results add up.

    Radiance in parts: the sum over tangents has a term for each, and `prepare(..., part=t)` leaves that of tangent t
    alone; W's normaliser keeps all tangents, so the parts add up to the whole. SceneBuffers.prepare takes the same
    `part`. Programs stay the same as far as `defines` do.
    """

    lights_solids = False  # else the light of solids is Gaussians and suns, each as far as it is seen
    behind = "inputs/visibility/behind_means.glsl"  # the file for "behind.glsl" of inputs/picture/shade_through.glsl
    source = ""  # the GLSL file with `vec3 L_o(vec3 omega_o, mat3 surface_from_world)`

    def __init__(self, ctx: moderngl.Context):
        self.ctx = ctx
        self.broad = np.zeros(0)  # how much [K] of each Gaussian is summed with others before its visibility is known
        self.albedo = np.zeros(3)  # what a bounce takes the fabric to reflect, where the method traces

    def prepare(self, fabric: Fabric, lights: Lights, settings: Settings, part: int | None = None) -> None:
        """Compute and upload what differs from the last call; cheap when nothing does.

        `part`: of the sum over the tangents only the term of this one. Raises InputError for settings out of range.
        """
        raise NotImplementedError

    def defines(self) -> dict[str, Any]:
        """Constants of the program. Nothing that a user edits live may be among them."""
        return {}

    def includes(self) -> dict[str, str]:
        """What `#include` means in `source`, by name."""
        return {}

    def inputs(self) -> dict[str, Any]:
        """Textures, buffers and uniforms by their names in GLSL."""
        return {}

    def woven_packing(self) -> tuple[int, int]:
        """How many vec4s hold the tangents where pixels show threads, and how many each."""
        raise NotImplementedError

    def woven_defines(self) -> dict[str, Any]:
        """Constants of its program for pixels that show threads, in place of those of `defines`."""
        return {}

    def woven_inputs(self) -> dict[str, Any]:
        """What its program reads beside `inputs` and the maps for pixels that show threads."""
        return {}

    def passes(self) -> Iterable[dict[str, Any]]:
        """The uniforms of each additive pass; one empty mapping where one pass does it all."""
        return [{}]

    def evaluations_per_pixel(self) -> int:
        """How many times a pixel evaluates one tangent for one direction, or what comes nearest to that."""
        raise NotImplementedError

    @property
    def traced(self) -> bool:
        """Whether `L_o` casts rays: then `set_geometry` must follow `prepare`."""
        return False

    def set_geometry(self, geometry: Geometry) -> list[Callable[[], None]]:
        """Say what rays from the cloth meet; returns what is to be called, in this order, before the draw."""
        return []

    def behind_includes(self) -> dict[str, str]:
        """What `#include` means in `behind`, by name."""
        return {}

    def solids_includes(self) -> dict[str, str]:
        """Where it `lights_solids`: what `#include` means, beside `defines`, where what stands about the cloth is shaded."""
        raise NotImplementedError

    def open_irradiance(self) -> np.ndarray:
        """Where it `lights_solids`: irradiance [3] of a ground that nothing hides from the light."""
        raise NotImplementedError

    def radiance(self, shared: SceneBuffers, omega_o: np.ndarray) -> np.ndarray:
        """Radiance [N, 3] toward directions [N, 3] of the surface frame, in which the lights are given too.

        0 where omega_o is below the surface. `shared` and this method are prepared for the same fabric and lights.
        """
        count = len(omega_o)
        virtual = {"method.glsl": self.source, "seen.glsl": "inputs/visibility/seen_all.glsl", **self.includes()}
        program = programs(self.ctx).compute("passes/methods/radiance.comp", self.defines(), virtual)
        directions = np.zeros((max(count, 1), 4), "f4")
        directions[:count, :3] = omega_o
        source, result = Buffer(self.ctx, directions), Buffer(self.ctx, np.zeros_like(directions))
        try:
            for uniforms in self.passes():
                inputs = shared.inputs(), self.inputs(), uniforms
                program.run(count, *inputs, Directions=source, Results=result, first=0, count=count)
            return np.frombuffer(result.read(), "f4").reshape(-1, 4)[:count, :3].copy()
        finally:
            source.release()
            result.release()

    def part_radiances(
        self, shared: SceneBuffers, fabric: Fabric, lights: Lights, settings: Settings, omega_o: np.ndarray
    ) -> np.ndarray:
        """As `radiance`, prepared for each tangent of a fabric in turn: [N, tangents, 3]."""
        parts = []
        for part in range(len(fabric.tangents)):
            shared.prepare(fabric, lights, part)
            self.prepare(fabric, lights, settings, part)
            parts.append(self.radiance(shared, omega_o))
        return np.stack(parts, 1)

    def release(self) -> None:
        """Free the GPU's memory."""
