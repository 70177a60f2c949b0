"""Shading at an adaptive rate: one pixel in four, and those others whose neighbours differ.   [own]"""

from __future__ import annotations

import moderngl

from .. import shader
from ..raster import GBuffer

TOLERANCE = 0.01  # of the relative error in luminance that the neighbours of a pixel let expect
BEND = 1.0
COARSE_UNIT = 5


class AdaptiveRate:
    """Runs a program of passes/shade.frag for every second pixel of every second row, and where that is not enough.

    A pixel is interpolated only if all its shaded neighbours see the same side of the same kind of frame, differ by at
    most `threshold` in luminance, and its own normal (known everywhere) lies where theirs put it. So where luminance is
    monotonic between them the error is at most `threshold`; docs/direct.md says what it is in fact.
    """

    def __init__(self, ctx: moderngl.Context, tolerance: float = TOLERANCE):
        self.ctx, self.tolerance = ctx, tolerance
        self._cover = shader.program(ctx, "passes/screen.vert", "passes/adaptive_cover.frag")
        self._fill = shader.program(ctx, "passes/screen.vert", "passes/adaptive_fill.frag")
        self._query = ctx.query(samples=True)
        self._buffer: GBuffer | None = None
        self._things: list = []

    def shade(self, buffer: GBuffer, program, narrowest_lobe: float) -> None:
        """Shade the covered pixels of a G-buffer into its colour target, as `GBuffer.shade` does at the full rate."""
        self._make(buffer)
        buffer.bind(self._cover)
        self._cover["pixel_stride"].value = 2
        # The screen triangle lies at depth 1: it passes `>` at depth 0, and early depth testing drops the other pixels.
        self._draw(self._cover, self._coarse, "1", True)
        buffer.bind(program)
        program["pixel_stride"].value = 2
        self._draw(program, self._coarse, ">", False)
        program["pixel_stride"].value = 1
        buffer.bind(self._fill)
        self._color.use(COARSE_UNIT)
        self._fill["tolerance"].value = self.tolerance
        self._fill["bend_limit"].value = BEND * narrowest_lobe
        self._draw(self._fill, self._fine, "1", True)
        buffer.bind(program)
        with self._query:
            self._draw(program, self._fine, ">", False)
        self.ctx.depth_func = "<"
        self.ctx.enable_only(moderngl.NOTHING)
        buffer.target.use()

    def shaded(self) -> int:
        """How many pixels the last call shaded beyond one in four."""
        return int(self._query.samples)

    def _draw(self, program, target: moderngl.Framebuffer, depth_func: str, write_depth: bool) -> None:
        target.use()
        target.viewport = (0, 0, *target.size)
        target.depth_mask = write_depth
        self.ctx.enable_only(moderngl.DEPTH_TEST)
        self.ctx.depth_func = depth_func
        array = self.ctx.vertex_array(program, [])
        array.render(moderngl.TRIANGLES, vertices=3)
        array.release()

    def _make(self, buffer: GBuffer) -> None:
        if self._things and self._buffer is buffer:
            return
        self.release()
        width, height = buffer.size
        size = (width // 2 + 1, height // 2 + 1)
        self._buffer = buffer
        self._color = self.ctx.texture(size, 4, dtype="f4")
        self._color.filter = moderngl.NEAREST, moderngl.NEAREST
        coarse_depth, fine_depth = self.ctx.depth_texture(size), self.ctx.depth_texture(buffer.size)
        self._coarse = self.ctx.framebuffer([self._color], coarse_depth)
        self._fine = self.ctx.framebuffer([buffer.color], fine_depth)
        self._things = [self._coarse, self._fine, self._color, coarse_depth, fine_depth]

    def release(self) -> None:
        """Free what belongs to the last G-buffer."""
        if self._things:
            self.ctx.detect_framebuffer(0).use()
        for thing in self._things:
            thing.release()
        self._things = []
