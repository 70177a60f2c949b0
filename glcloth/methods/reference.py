"""Method `reference`: every direction of a cube map, summed per pixel in additive passes (paper A's reference pictures),
with a ray for each of them when there are shadows."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from typing import Any, NamedTuple

import moderngl
import numpy as np

from ..accel.structure import tracing
from ..fabric import Fabric
from ..gpu.buffers import TextureBuffer
from ..gpu.memo import Last, same
from ..gpu.programs import programs
from ..light.environment import cube_map, cube_map_of_gaussians
from ..light.lights import Lights, Suns
from ..twins.sun_disc import disc_directions
from ..visibility.sheets import sight
from .albedo import diffuse_albedo
from .method import Geometry, Method
from .settings import Settings

# Directions per pass: far below llvmpipe's 65,535 loop iterations per invocation even with 32 tangents, and short
# enough (about a second a pass at 640x480 without a GPU) for progress and Ctrl-C.
CHUNK = 256
TRACED_CHUNK = 16  # their rays have loops too, through eight sheets of cloth at most: together below 65,535 rounds
LIT_CHUNK = 2  # directions that light the vertices at a time: a caller in between waits for no more
SUN_POINTS = 64  # directions of a sun's disc
BOUNCE_CUBE = 16  # edge of the cube map that lights the vertices for a bounce: irradiance is smooth


class Directions(NamedTuple):
    """What is summed over."""

    omega: np.ndarray  # [D, 3]
    flux: np.ndarray  # [D, 3]
    solid_angle: np.ndarray  # [D]
    cast: np.ndarray  # [D], 1 where a ray decides whether the flux arrives


def points_of(suns: Suns, count: int) -> Suns:
    """So many points of each sun's disc as suns; for one its middle."""
    if count == 1 or not len(suns):
        return suns
    each = zip(suns.direction, np.asarray(suns.radius), strict=True)
    direction = np.concatenate([disc_directions(middle, radius, count) for middle, radius in each])
    return Suns(direction, np.repeat(suns.irradiance / count, count, axis=0), 0.0)


class Reference(Method):
    """Sums f_cloth times flux over directions: the judge of the other methods.

    With light "map" the directions are the texels of the environment itself; with "sg" the same texels under the
    fitted lights, so that a comparison sees the method's error alone. With shadows a ray from every pixel decides of
    every direction ("full") or of the suns ("sun"); with `bounce` a direction that cloth hides brings that cloth's
    own radiance: the fabric's diffuse albedo / pi times the irradiance at the hit, interpolated between the vertices.
    """

    lights_solids = True
    behind = "inputs/methods/behind_sum.glsl"

    def __init__(self, ctx: moderngl.Context):
        super().__init__(ctx)
        self._data = TextureBuffer(ctx, 32 * 6 * 32 * 32)
        self._uploaded: Last[int] = Last()
        self._settings = Settings()
        self._tangents = 0
        # With shadows: what rays meet, and with a bounce the irradiance of the vertices.
        self._geometry: Geometry = None  # type: ignore[assignment]  # `set_geometry` follows where it is read
        self._sun_directions = 0  # the last ones
        self._cube_from_world = np.eye(3)
        self._mirror_sharpness = 1.0  # of what sheer cloth mirrors
        self._vertex_lights, self._irradiance = TextureBuffer(ctx, 16), TextureBuffer(ctx, 16)
        self._light: tuple = ()  # what the irradiance is of, beside the geometry,
        self._lit: tuple | None = None  # and both once it is made
        self._albedo: Last[np.ndarray] = Last()

    # -- what a draw needs ---------------------------------------------------------------------------------------

    @property
    def source(self) -> str:  # type: ignore[override]
        """The pass file with `L_o`."""
        return "inputs/methods/reference_traced.glsl" if self.traced else "inputs/methods/reference.glsl"

    @property
    def traced(self) -> bool:
        """Whether rays are cast: then `set_geometry` must follow `prepare`."""
        return self._settings.shadows != "off"

    @property
    def bounces(self) -> bool:
        """Whether light goes from cloth to cloth once."""
        return self._settings.shadows == "full" and self._settings.bounce

    def defines(self) -> dict[str, Any]:
        """Whether rays can meet anything but the cloth itself."""
        if not self.traced:
            return {}
        return {**({"SEVERAL_SURFACES": 1} if self._geometry.several else {}), **self._geometry.finer}

    def woven_packing(self) -> tuple[int, int]:
        """In the order of the tangents."""
        return -(-self._tangents // 4), 4

    def includes(self) -> dict[str, str]:
        """How rays are traced, and what they look for."""
        if not self.traced:
            return {}
        visit = "inputs/accel/visit_closest.glsl" if self.bounces else "inputs/accel/visit_any.glsl"
        virtual = {"visit.glsl": visit, **tracing(self._geometry.structure)}
        return virtual | {"inputs/visibility/along_ray.glsl": self._along}

    def behind_includes(self) -> dict[str, str]:
        """As for solids."""
        return {"along.glsl": self._along, **self.includes()}

    def prepare(self, fabric: Fabric, lights: Lights, settings: Settings, part: int | None = None) -> None:
        """Upload the directions and their flux when the lights, the map or the resolution changed.

        `part` is in the fabric's records alone; what a bounce brings is always of the whole fabric.
        """
        self._tangents, self._settings = len(fabric.tangents), settings
        self.broad = np.zeros(len(lights.gaussians))
        self.albedo = self._albedo.get(lambda: diffuse_albedo(fabric), fabric) if self.bounces else np.zeros(3)
        # Maps and lights are frozen, so the same object means the same light.
        source = settings.environment if settings.light == "map" else lights
        rotation = None if settings.rotation is None else np.asarray(settings.rotation, float).tobytes()
        turned = settings.light == "map" and settings.rotation is not None
        self._cube_from_world = np.asarray(settings.rotation).T if turned else np.eye(3)
        self._light = settings.light, source, rotation, min(settings.cube, BOUNCE_CUBE)
        self._bounce_light = partial(self._directions, lights, settings, min(settings.cube, BOUNCE_CUBE))
        points = SUN_POINTS if settings.light != "map" and np.any(lights.suns.radius) else 1
        # About four directions are within it.
        self._mirror_sharpness = 6 * settings.cube**2 / 8
        self._sun_directions = 0 if settings.light == "map" else points * len(lights.suns)
        self._uploaded.get(
            lambda: self._upload_light(self._directions(lights, settings, settings.cube, points)),
            *(settings.light, source, rotation, settings.cube, settings.shadows, self.bounces),
        )

    def _directions(self, lights: Lights, settings: Settings, cube: int, points: int = 1) -> Directions:
        """Every direction that light comes from, the last of them so many points of each sun."""
        if settings.light == "map":
            assert settings.environment is not None
            omega, solid_angle, radiance = cube_map(settings.environment, cube)
            omega = omega if settings.rotation is None else omega @ np.asarray(settings.rotation).T
            flux = solid_angle[:, None] * radiance
            cast = np.full(len(omega), settings.shadows == "full")
        else:
            omega, solid_angle, radiance = cube_map_of_gaussians(lights.gaussians, cube)
            # Suns keep their own directions: half a texel is a degree and a half, and narrow lobes see that.
            suns = points_of(lights.suns, points)
            flux = np.concatenate([solid_angle[:, None] * radiance, suns.irradiance])
            omega = np.concatenate([omega, suns.direction])
            cast = np.concatenate([np.full(len(solid_angle), settings.shadows == "full"), np.ones(len(suns))])
            # No light comes back from a sun's direction beyond what its texel brings.
            solid_angle = np.concatenate([solid_angle, np.zeros(len(suns))])
        return Directions(omega, flux, solid_angle, cast)

    def _upload_light(self, directions: Directions) -> int:
        """Upload the directions of the sum; returns how many."""
        self._open = (np.maximum(directions.omega[:, 1:2], 0.0) * directions.flux).sum(0)
        return self._upload(self._data, directions)

    def open_irradiance(self) -> np.ndarray:
        return self._open

    def _upload(self, data: TextureBuffer, directions: Directions) -> int:
        """Upload the directions that can bring light; returns how many."""
        omega, flux, solid_angle, cast = directions
        # All points of suns, for the passes count them.
        used = np.any(flux != 0.0, axis=1) | self.bounces | (solid_angle == 0.0)
        records = np.zeros((int(used.sum()), 2, 4), "f4")
        records[:, 0, :3], records[:, 1, :3] = omega[used], flux[used]
        records[:, 1, 3] = solid_angle[used]
        if self.traced:
            records[:, 0, 3] = cast[used]
        data.write(records)
        return len(records)

    def set_geometry(self, geometry: Geometry) -> list[Callable[[], None]]:
        """Say what rays meet; returns the dispatches that light the vertices for a bounce."""
        self._geometry = geometry
        sheets = None if geometry.sheets is None else geometry.sheets.transmissions
        key = self._light, geometry.meshes, sheets
        if not self.bounces or same(self._lit, key):
            return []
        self._lit = None
        light = self._bounce_light()
        bright = light.flux.any(axis=1)
        count = self._upload(self._vertex_lights, Directions(*(column[bright] for column in light)))
        self._irradiance.write(np.zeros((geometry.hit_vertices.vertex_count, 2, 4), "f4"))

        def finished() -> None:
            self._lit = key

        return [*(partial(self._light_vertices, first, count) for first in range(0, count, LIT_CHUNK)), finished]

    def _light_vertices(self, first: int, count: int) -> None:
        """Add the irradiance on both sides of every vertex from some of the directions, a ray for each."""
        structure, hit = self._geometry.structure, self._geometry.hit_vertices
        defines, virtual, rays = sight(structure, self._geometry.sheets)
        program = programs(self.ctx).compute("passes/methods/reference_irradiance.comp", defines, virtual)
        program.run(
            hit.vertex_count,
            rays,
            hit.inputs(),
            direction_data=self._vertex_lights,
            Irradiance=self._irradiance,
            vertex_count=hit.vertex_count,
            first_direction=first,
            direction_count=min(LIT_CHUNK, count - first),
            offset=hit.offset,
        )
        self.ctx.finish()  # so that progress tells the truth and Ctrl-C is heard

    def inputs(self) -> dict[str, Any]:
        """What the pass file and inputs/picture/shade_lambert.glsl read, but for the range of a pass."""
        own = {
            "direction_data": self._data,
            "mirror_sharpness": self._mirror_sharpness,
            "cube_from_world": self._cube_from_world,
        }
        if not self.traced:
            return own
        return {
            **self._geometry.inputs(),
            **own,
            "irradiance_data": self._irradiance if self.bounces else self._data,
            "bounces": self.bounces,
            "light_behind": self.bounces,
        }

    @property
    def _along(self) -> str:
        """The file with `flux_along`."""
        if not self.traced:
            return "inputs/visibility/along_everything.glsl"
        sheer = self._geometry.sheets is not None
        return "inputs/visibility/along_sheer.glsl" if sheer else "inputs/visibility/along_ray.glsl"

    def solids_includes(self) -> dict[str, str]:
        return {"lit.glsl": "inputs/visibility/lit_sum.glsl", "along.glsl": self._along, **self.includes()}

    def passes(self) -> Iterator[dict[str, Any]]:
        """So many directions at a time; those of suns by themselves, for others things hide them."""
        count = self._uploaded.value or 0
        chunk = TRACED_CHUNK if self.traced else CHUNK
        of_suns = count - self._sun_directions if self._suns_apart else count
        for first in range(0, of_suns, chunk):
            yield {"first_direction": first, "direction_count": min(chunk, of_suns - first)}
        for first in range(of_suns, count, chunk):
            yield {"first_direction": first, "direction_count": min(chunk, count - first), **self._toward_suns()}

    @property
    def _suns_apart(self) -> bool:
        """Whether suns have passes of their own."""
        return self.traced and self._sun_directions > 0

    def _toward_suns(self) -> dict[str, Any]:
        """What these passes read else."""
        if self._geometry is None or self._geometry.sun_occluders is None:
            return {}
        return self._geometry.sun_occluders.inputs()

    def evaluations_per_pixel(self) -> int:
        """Directions times tangents."""
        return (self._uploaded.value or 0) * self._tangents

    def release(self) -> None:
        """Free the GPU's memory."""
        for one in (self._data, self._vertex_lights, self._irradiance):
            one.release()
