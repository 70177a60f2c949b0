"""The share that a fabric reflects of light evenly from everywhere, for a bounce.   [own, docs/shadows.md]"""

from __future__ import annotations

import moderngl
import numpy as np

from ..gpu.buffers import Buffer, TextureBuffer
from ..gpu.memo import Last
from ..gpu.programs import programs
from ..gpu.scene_buffers import SceneBuffers
from ..twins.directions import cosine_directions, even_directions

ALBEDO_VIEWS, ALBEDO_LIGHTS = 64, 256  # directions
VIEWS = 24, 12  # azimuths and cosines of a viewer
LIGHTS = 512  # directions, for each of these; each goes through all tangents, and a loop may end after 65,535 rounds


class Furnace:
    """Keeps the results for the last fabric; `source` has the fabric on the GPU."""

    def __init__(self, ctx: moderngl.Context):
        self.ctx = ctx
        self._albedo: Last[np.ndarray] = Last()
        self._views: Last[moderngl.TextureArray] = Last()
        self._directions: Last[TextureBuffer] = Last()  # of `albedo`
        self._lights: Last[TextureBuffer] = Last()  # of `views`

    def albedo(self, source: SceneBuffers) -> np.ndarray:
        """The reflected share [3] of light that comes evenly from everywhere, in the mean over all views by their cosine."""
        return self._albedo.get(lambda: self._measure_albedo(source), source.fabric)

    def _measure_albedo(self, source: SceneBuffers) -> np.ndarray:
        directions = (cosine_directions(ALBEDO_VIEWS), even_directions(ALBEDO_LIGHTS))
        points = self._directions.get(lambda: _texels(self.ctx, *directions))
        results = Buffer(self.ctx, 16 * ALBEDO_VIEWS)
        counts = {"view_count": ALBEDO_VIEWS, "light_count": ALBEDO_LIGHTS}
        program = programs(self.ctx).compute("passes/methods/furnace.comp")
        program.run(ALBEDO_VIEWS, source.inputs(), counts, point_data=points, Results=results)
        radiance = np.frombuffer(results.read(), "f4").reshape(-1, 4)[:, :3]
        results.release()
        return np.clip(radiance.mean(0), 0.0, 1.0)

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
