"""Method `reference`: every direction of a cube map, summed per pixel in additive passes (paper A's reference pictures),
with a ray for each of them when there are shadows."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial

import numpy as np

from ..gpu import shader
from ..gpu.buffers import TextureBuffer
from ..light.environment import cube_map, cube_map_of_gaussians
from ..settings import Settings
from ..visibility.hit_vertices import HitSurface, HitVertices
from .albedo import diffuse_albedo

# Directions per pass: far below llvmpipe's 65,535 loop iterations per invocation even with 32 tangents, and short
# enough (about a second a pass at 640x480 without a GPU) for progress and Ctrl-C.
CHUNK = 256
TRACED_CHUNK = 64  # the steps and triangles of 64 rays count too
DIRECTION_UNIT = 8
TRACED_UNITS = {"directions": 10, "irradiance": 11, "corners": 12, "vertices": 13}
LIT_CHUNK = 2  # directions that light the vertices at a time: a caller in between waits for no more
BOUNCE_CUBE = 16  # edge of the cube map that lights the vertices for a bounce: irradiance is smooth


class Reference:
    """Sums f_cloth times flux over directions: the judge of the other methods.

    With light "map" the directions are the texels of the environment itself; with "sg" the same texels under the
    fitted lights, so that a comparison sees the method's error alone. With shadows a ray from every pixel decides of
    every direction ("full") or of the suns ("sun"); with `bounce` a direction that cloth hides brings that cloth's
    own radiance: the fabric's diffuse albedo / pi times the irradiance at the hit, interpolated between the vertices.
    """

    def __init__(self, ctx):
        self.ctx = ctx
        self._data = TextureBuffer(ctx, 32 * 6 * 32 * 32)
        self._key = None
        self._settings = Settings()
        self._count = self._tangents = 0
        # With shadows: the mesh and the structure over what hides light; the vertices' irradiance, and of what.
        self._mesh = self._structure = self._irradiance = self._lit = None
        self._vertex_lights: TextureBuffer | None = None
        self._irradiance_programs: dict = {}
        self._around = None
        self._places = HitVertices(ctx)
        self._albedo: tuple | None = None  # of which fabric, its diffuse albedo
        self._radiance_per_irradiance = (0.0, 0.0, 0.0)

    # -- what a draw needs ---------------------------------------------------------------------------------------

    @property
    def source(self) -> str:
        """The pass file with `L_o`."""
        return "inputs/methods/reference" + ("_traced" if self.traced else "") + ".glsl"

    @property
    def traced(self) -> bool:
        """Whether rays are cast: then `place` must follow `prepare`."""
        return self._settings.shadows != "off"

    @property
    def bounces(self) -> bool:
        """Whether light goes from cloth to cloth once."""
        return self._settings.shadows == "full" and self._settings.bounce

    def includes(self) -> dict:
        """What `#include` means in `source`, by name."""
        if not self.traced:
            return {}
        visit = "closest" if self.bounces else "any"
        return {"visit.glsl": f"inputs/accel/visit_{visit}.glsl", **self._traversal()}

    def _traversal(self) -> dict:
        return {"accel.glsl": self._structure.source, "count.glsl": "inputs/accel/count_none.glsl"}

    def prepare(self, fabric, lights, settings: Settings) -> None:
        """Upload the directions and their flux when the lights, the map or the resolution changed."""
        self._tangents = len(fabric.tangents)
        self._settings = settings
        self._radiance_per_irradiance = (0.0, 0.0, 0.0)
        if self.bounces:
            if self._albedo is None or self._albedo[0] is not fabric:
                self._albedo = fabric, self.diffuse_albedo(fabric)
            self._radiance_per_irradiance = tuple(map(float, self._albedo[1] / np.pi))
        rotation = None if settings.rotation is None else np.asarray(settings.rotation, float).tobytes()
        # Arrays have no cheap equality: maps and lights are frozen, so the same object means the same light.
        source = id(settings.environment) if settings.light == "map" else id(lights)
        key = (settings.light, settings.cube, source, rotation, settings.shadows, self.bounces)
        if key == self._key:
            return
        self._kept_alive = settings.environment, lights  # an id stays unique only while its object lives
        self._light_key = key[:1] + key[2:4]
        self._count = self._upload(self._data, *self._directions(lights, settings, settings.cube))
        self._key = key

    def diffuse_albedo(self, fabric) -> np.ndarray:
        """Albedo [3] of the bounce."""
        return diffuse_albedo(fabric)

    def _directions(self, lights, settings: Settings, cube: int) -> tuple[np.ndarray, ...]:
        """Directions [D, 3], flux [D, 3], solid angles [D], and which of them [D] are cast as rays."""
        if settings.light == "map":
            omega, solid_angle, radiance = cube_map(settings.environment, cube)
            omega = omega if settings.rotation is None else omega @ np.asarray(settings.rotation).T
            flux = solid_angle[:, None] * radiance
            cast = np.full(len(omega), settings.shadows == "full")
        else:
            omega, solid_angle, radiance = cube_map_of_gaussians(lights.gaussians, cube)
            # Suns keep their own directions: half a texel is a degree and a half, and narrow lobes see that.
            flux = np.concatenate([solid_angle[:, None] * radiance, lights.suns.irradiance])
            omega = np.concatenate([omega, lights.suns.direction])
            cast = np.concatenate([np.full(len(solid_angle), settings.shadows == "full"), np.ones(len(lights.suns))])
            # No light comes back from a sun's direction beyond what its texel brings.
            solid_angle = np.concatenate([solid_angle, np.zeros(len(lights.suns))])
        return omega, flux, solid_angle, cast

    def _upload(self, data: TextureBuffer, omega, flux, solid_angle, cast) -> int:
        """Upload the directions that can bring light; returns how many."""
        used = np.any(flux != 0.0, axis=1) | self.bounces
        records = np.zeros((int(used.sum()), 2, 4), "f4")
        records[:, 0, :3], records[:, 1, :3] = omega[used], flux[used]
        if self.traced:
            records[:, 0, 3], records[:, 1, 3] = cast[used], solid_angle[used]
        data.write(records)
        return len(records)

    def place(self, mesh, structure, around=None) -> list[Callable[[], None]]:
        """Say where the cloth is and what hides light from it; needed when `traced`.

        Parameters
        ----------
        mesh : raster.MeshBuffers of the cloth
        structure : of glcloth.accel, built; its first triangles are the mesh's, then come those of `around`
        around : cloth.around.Around, what stands about the cloth, if anything

        Returns what is to be called, in this order, before the draw: the dispatches that light the vertices for a bounce.
        """
        self._mesh, self._structure, self._around = mesh, structure, around
        surfaces = [HitSurface(mesh.mesh, mesh.mesh), *([around.hit_surface] if around else [])]
        self._places.prepare(surfaces, structure.triangles)
        key = self._light_key, mesh, around and around.mesh
        if not self.bounces or self._lit == key:
            return []
        self._lit = None
        _, lights = self._kept_alive
        if self._vertex_lights is None:
            self._vertex_lights, self._irradiance = TextureBuffer(self.ctx, 16), TextureBuffer(self.ctx, 16)
        light = self._directions(lights, self._settings, min(self._settings.cube, BOUNCE_CUBE))
        bright = light[1].any(axis=1)
        count = self._upload(self._vertex_lights, *(column[bright] for column in light))
        self._irradiance.write(np.zeros((self._places.vertex_count, 2, 4), "f4"))
        jobs = [partial(self._light_vertices, first, count) for first in range(0, count, LIT_CHUNK)]

        def finished() -> None:
            self._lit = key

        return [*jobs, finished]

    def _light_vertices(self, first: int, count: int) -> None:
        """Add the irradiance on both sides of every vertex from some of the directions, a ray for each."""
        source = self._structure.source
        if source not in self._irradiance_programs:
            virtual = {"visit.glsl": "inputs/accel/visit_any.glsl", **self._traversal()}
            self._irradiance_programs[source] = shader.compute(
                self.ctx, "passes/methods/reference_irradiance.comp", None, virtual
            )
        program = self._irradiance_programs[source]
        self._structure.bind(program)
        self._vertex_lights.bind(TRACED_UNITS["directions"])
        self._places.bind(program, TRACED_UNITS["corners"], TRACED_UNITS["vertices"])
        self._irradiance.buffer.bind_to_storage_buffer(0)
        shader.set_uniforms(
            program,
            vertex_count=self._places.vertex_count,
            first_direction=first,
            direction_count=min(LIT_CHUNK, count - first),
            offset=self._places.offset,
        )
        program.run(-(-self._places.vertex_count // 64))
        self.ctx.memory_barrier()
        self.ctx.finish()  # so that progress tells the truth and Ctrl-C is heard

    def defines(self) -> dict:
        return {"AROUND_CLOTH": 1} if self.traced and self._around is not None else {}

    def bind(self, program) -> None:
        if not self.traced:
            self._data.bind(DIRECTION_UNIT)
            return
        self._structure.bind(program)
        self._data.bind(TRACED_UNITS["directions"])
        (self._irradiance if self.bounces else self._data).bind(TRACED_UNITS["irradiance"])
        self._places.bind(program, TRACED_UNITS["corners"], TRACED_UNITS["vertices"])
        shader.set_uniforms(
            program,
            cloth_triangles=self._places.first_triangle[1],
            radiance_per_irradiance=self._radiance_per_irradiance,
            bounces=self.bounces,
        )
        if self._around is not None:
            self._around.bind(program)

    def lit(self, around):
        """The program of passes/picture/lambert.frag that lights what stands about the cloth by the same sum, bound."""
        along = "inputs/visibility/along_ray.glsl" if self.traced else "inputs/visibility/along_everything.glsl"
        program = around.program(
            "inputs/visibility/lit_sum.glsl", self.defines(), {"along.glsl": along, **self.includes()}
        )
        if not self.traced:
            self._data.bind(TRACED_UNITS["directions"])
        else:
            self.bind(program)
        return program

    def passes(self) -> Iterator[dict]:
        chunk = TRACED_CHUNK if self.traced else CHUNK
        for first in range(0, self._count, chunk):
            yield {"first_direction": first, "direction_count": min(chunk, self._count - first)}

    def evaluations_per_pixel(self) -> int:
        """Directions times tangents."""
        return self._count * self._tangents
