"""A texture with a depth buffer that triangles and lines are drawn into."""

from __future__ import annotations

from collections.abc import Sequence

import moderngl
import numpy as np

from ..gpu.buffers import read_texture
from ..gpu.programs import Draw


class Canvas:
    """A picture of a size: `texture`, RGBA, linear, bottom row first."""

    def __init__(self, ctx: moderngl.Context, size: tuple[int, int]):
        self.ctx = ctx
        self.texture = ctx.texture(size, 4, dtype="f4")
        self._depth = ctx.depth_renderbuffer(size)
        self._target = ctx.framebuffer([self.texture], self._depth)

    def clear(self, color: Sequence[float]) -> None:
        """Fill it with a colour [3]."""
        self._target.clear(color=(float(color[0]), float(color[1]), float(color[2]), 1.0))

    def draw(self, program: Draw, mode: int, vertices: int, first: int = 0, blend: bool = False) -> None:
        """Draw vertices that the program, bound, fetches by their numbers; nearer surfaces hide them.

        blend : blend by alpha, premultiplied, and hide nothing
        """
        # Between two draws others may have drawn elsewhere.
        self._target.use()
        self._target.depth_mask = not blend
        self.ctx.viewport = (0, 0, *self.texture.size)
        self.ctx.enable_only(moderngl.DEPTH_TEST | (moderngl.BLEND if blend else 0))
        self.ctx.blend_func = moderngl.ONE, moderngl.ONE_MINUS_SRC_ALPHA
        program.screen.render(mode, vertices=vertices, first=first)
        self._target.depth_mask = True
        self.ctx.enable_only(moderngl.NOTHING)
        # moderngl binds the last framebuffer back after making a new one; it must not be a deleted one.
        self.ctx.detect_framebuffer(0).use()

    def pixels(self) -> np.ndarray:
        """Return float32 [H, W, 3], top row first."""
        width, height = self.texture.size
        data = np.frombuffer(read_texture(self.texture), np.float32).reshape(height, width, 4)
        return data[::-1, :, :3].copy()

    def release(self) -> None:
        """Free the GPU's memory."""
        self.ctx.detect_framebuffer(0).use()
        for thing in (self._target, self._depth, self.texture):
            thing.release()
