"""The radiance of several Gaussians together, as a map that a shader looks up instead of evaluating each.   [own]"""

from __future__ import annotations

import moderngl
import numpy as np

from ...gpu.buffers import TextureBuffer
from ...gpu.layout import shared
from ...gpu.memo import Last
from ...gpu.programs import programs
from ...light.lights import SphericalGaussians

# Texels a side: sharpness 30 needs one of a degree.
SIZE = int(shared("inputs/methods/direct.glsl")[0]["MAP_SIZE"])


class LightMap:
    """An octahedral map in world space, black at first."""

    def __init__(self, ctx: moderngl.Context):
        self.ctx = ctx
        self.texture = ctx.texture((SIZE, SIZE), 4, bytes(16 * SIZE * SIZE), dtype="f4")
        self.texture.filter = moderngl.LINEAR, moderngl.LINEAR
        self.texture.repeat_x = self.texture.repeat_y = False
        self._data = TextureBuffer(ctx, 32 * 64)
        self._drawn: Last[None] = Last()

    def draw(self, gaussians: SphericalGaussians, share: np.ndarray) -> None:
        """Draw the given shares [K] of the Gaussians; nothing while they are the same."""
        mine = share > 0.0
        records = np.zeros((int(mine.sum()), 2, 4), "f4")
        records[:, 0, :3], records[:, 0, 3] = gaussians.axis[mine], gaussians.sharpness[mine]
        records[:, 1, :3] = gaussians.amplitude[mine] * share[mine, None]
        self._drawn.get(lambda: self._draw(records), records.tobytes())

    def _draw(self, records: np.ndarray) -> None:
        self._data.write(records)
        programs(self.ctx).compute("passes/methods/light_map.comp").run(
            (SIZE, SIZE), gaussian_data=self._data, light_map=self.texture, gaussian_count=len(records)
        )

    def release(self) -> None:
        """Free the GPU's memory."""
        self.texture.release()
        self._data.release()
