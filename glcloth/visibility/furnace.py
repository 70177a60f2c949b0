"""The share that a fabric reflects of light evenly from everywhere, for a bounce.   [own, docs/shadows.md]"""

from __future__ import annotations

from typing import NamedTuple

import moderngl
import numpy as np

from ..color import luminance
from ..gpu.buffers import Buffer, TextureBuffer
from ..gpu.memo import Last
from ..gpu.programs import programs
from ..gpu.scene_buffers import SceneBuffers
from ..twins.directions import cosine_directions, even_directions

ALBEDO_VIEWS, ALBEDO_LIGHTS = 64, 256  # directions
VIEWS = 24, 12  # azimuths and cosines of a viewer
MOST_FLAT = 0.9  # above 0.5 a fabric gives back less of a beam the more upright it is
LIGHTS = 512  # directions, for each of these; each goes through all tangents, and a loop may end after 65,535 rounds


class Given(NamedTuple):
    """What a surface gives back, by cosines, summed over all else; of a Lambertian both are 0.

    Parameters
    ----------
    flat_share : of a beam from the cosine z: albedo (flat_share + (1 - 2 flat_share) z), see `response_to` of
        glsl/trace/visibility.glsl; 0.2 for linen, 0.4 for silk
    upright : toward the cosine z, of even light: albedo (1 + upright (z - 2/3)), half of what it is by itself; 0.4 for
        poplin
    upright_of_height : what that grows by for each unit of the beam's cosine
    """

    flat_share: float = 0.0
    upright: float = 0.0
    upright_of_height: float = 0.0


class Furnace:
    """Keeps the results for the last fabric; `source` has the fabric on the GPU."""

    def __init__(self, ctx: moderngl.Context):
        self.ctx = ctx
        self._albedo: Last[tuple[np.ndarray, Given]] = Last()
        self._views: Last[moderngl.TextureArray] = Last()
        self._directions: Last[TextureBuffer] = Last()  # of `albedo`
        self._lights: Last[TextureBuffer] = Last()  # of `views`

    def albedo(self, source: SceneBuffers) -> np.ndarray:
        """The reflected share [3] of light that comes evenly from everywhere, in the mean over all views by their cosine."""
        return self._albedo.get(lambda: self._measure_albedo(source), source.fabric)[0]

    def given(self, source: SceneBuffers) -> Given:
        """How what the fabric gives back differs from a Lambertian's."""
        return self._albedo.get(lambda: self._measure_albedo(source), source.fabric)[1]

    def _measure_albedo(self, source: SceneBuffers) -> tuple[np.ndarray, Given]:
        directions = (cosine_directions(ALBEDO_VIEWS), even_directions(ALBEDO_LIGHTS))
        points = self._directions.get(lambda: _texels(self.ctx, *directions))
        results = Buffer(self.ctx, 16 * ALBEDO_VIEWS)
        counts = {"view_count": ALBEDO_VIEWS, "light_count": ALBEDO_LIGHTS}
        program = programs(self.ctx).compute("passes/methods/furnace.comp")
        program.run(ALBEDO_VIEWS, source.inputs(), counts, point_data=points, Results=results)
        found = np.frombuffer(results.read(), "f4").reshape(-1, 4)
        results.release()
        light = luminance(found[:, :3].astype(float))
        # Least squares by the cosines of light (evenly from 0 to 1) and view (by itself), less their means.
        whole, of_height = max(light.sum(), 1e-12), found[:, 3] - 0.5 * light
        view = directions[0][:, 2] - 2.0 / 3.0
        from_height = 0.5 + of_height.sum() / whole  # the mean cosine of light that is given back: 2/3 - flat_share / 3
        flat_share = float(np.clip(2.0 - 3.0 * from_height, 0.0, MOST_FLAT))
        # Half the slope by the view: light that comes from one side leaves more along the surface than even light does.
        slopes = 9.0 * (light * view).sum() / whole, 9.0 * 12.0 * (of_height * view).sum() / whole
        return np.clip(found[:, :3].mean(0), 0.0, 1.0), Given(flat_share, *map(float, slopes))

    def views(self, source: SceneBuffers) -> moderngl.TextureArray:
        """The radiance toward each viewer, and how much that follows the light's direction, as
        inputs/visibility/seen_occluders.glsl reads them."""
        return self._views.get(lambda: self._measure_views(source), source.fabric)

    def _measure_views(self, source: SceneBuffers) -> moderngl.TextureArray:
        points = self._lights.get(lambda: _texels(self.ctx, even_directions(LIGHTS)))
        texture = self._views.value
        if texture is None:
            texture = self.ctx.texture_array((*VIEWS, 2), 4, dtype="f2")
            texture.filter = moderngl.LINEAR, moderngl.LINEAR
            texture.repeat_x, texture.repeat_y = True, False
        program = programs(self.ctx).compute("passes/methods/furnace_views.comp")
        program.run(VIEWS, source.inputs(), point_data=points, views=texture, light_count=LIGHTS)
        return texture


def _texels(ctx: moderngl.Context, *directions: np.ndarray) -> TextureBuffer:
    rows = np.concatenate(directions)
    return TextureBuffer(ctx, np.pad(rows, ((0, 0), (0, 1))).astype("f4"))
