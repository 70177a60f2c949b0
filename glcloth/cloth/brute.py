"""Method `reference`: every direction of a cube map, summed per pixel in additive passes (paper A's reference pictures)."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ..environment import cube_map, cube_map_of_gaussians
from ..gpu import TextureBuffer
from .settings import Settings

# Directions per pass: far below llvmpipe's 65,535 loop iterations per invocation even with 32 tangents, and short
# enough (about a second a pass at 640x480 without a GPU) for progress and Ctrl-C.
CHUNK = 256
DIRECTION_UNIT = 8


class Reference:
    """Sums f_cloth times flux over directions: the judge of the other methods.

    With light "map" the directions are the texels of the environment itself; with "sg" the same texels under the
    fitted lights, so that a comparison sees the method's error alone.
    """

    source = "passes/method_reference.glsl"

    def __init__(self, ctx):
        self._data = TextureBuffer(ctx, 32 * 6 * 32 * 32)
        self._key = None
        self._count = self._tangents = 0

    def prepare(self, fabric, lights, settings: Settings) -> None:
        """Upload the directions and their flux when the lights, the map or the resolution changed."""
        self._tangents = len(fabric.tangents)
        rotation = None if settings.rotation is None else np.asarray(settings.rotation, float).tobytes()
        # Arrays have no cheap equality: maps and lights are frozen, so the same object means the same light.
        source = id(settings.environment) if settings.light == "map" else id(lights)
        key = (settings.light, settings.cube, source, rotation)
        if key == self._key:
            return
        self._kept_alive = settings.environment, lights  # an id stays unique only while its object lives
        if settings.light == "map":
            omega, solid_angle, radiance = cube_map(settings.environment, settings.cube)
            omega = omega if settings.rotation is None else omega @ np.asarray(settings.rotation).T
            self._upload(omega, solid_angle[:, None] * radiance)
        else:
            omega, solid_angle, radiance = cube_map_of_gaussians(lights.gaussians, settings.cube)
            # Suns keep their own directions: half a texel is a degree and a half, and narrow lobes see that.
            flux = np.concatenate([solid_angle[:, None] * radiance, lights.suns.irradiance])
            self._upload(np.concatenate([omega, lights.suns.direction]), flux)
        self._key = key

    def _upload(self, omega: np.ndarray, flux: np.ndarray) -> None:
        dark = ~np.any(flux != 0.0, axis=1)
        omega, flux = omega[~dark], flux[~dark]
        records = np.zeros((len(omega), 2, 4), "f4")
        records[:, 0, :3], records[:, 1, :3] = omega, flux
        self._data.write(records)
        self._count = len(omega)

    def defines(self) -> dict:
        return {}

    def bind(self, program) -> None:
        self._data.bind(DIRECTION_UNIT)

    def passes(self) -> Iterator[dict]:
        for first in range(0, self._count, CHUNK):
            yield {"first_direction": first, "direction_count": min(CHUNK, self._count - first)}

    def evaluations_per_pixel(self) -> int:
        """Directions times tangents."""
        return self._count * self._tangents
