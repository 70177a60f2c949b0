"""The environment as a texture: the background of a picture, and of rays that leave the scene."""

from __future__ import annotations

import moderngl
import numpy as np

from ..light.environment import Environment
from .memo import Last


class EnvironmentMap:
    """Keeps the texture of the last environment."""

    def __init__(self, ctx: moderngl.Context):
        self.ctx = ctx
        self._texture: Last[moderngl.Texture] = Last(frees=True)

    def texture(self, environment: Environment) -> moderngl.Texture:
        """The equirectangular texture of an environment; the one before is freed."""
        return self._texture.get(lambda: self._made(environment), environment)

    def _made(self, environment: Environment) -> moderngl.Texture:
        height, width = environment.radiance.shape[:2]
        data = np.ascontiguousarray(environment.radiance, "f4").tobytes()
        texture = self.ctx.texture((width, height), 3, data, dtype="f4", alignment=4)
        texture.repeat_x, texture.repeat_y = True, False
        texture.filter = moderngl.LINEAR, moderngl.LINEAR
        return texture

    def release(self) -> None:
        """Free the texture."""
        self._texture.release()
