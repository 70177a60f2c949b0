"""Shading at an adaptive rate: one pixel in four, and those others that their neighbours do not determine.   [own]"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import moderngl
import numpy as np

from ..gpu import shader
from ..gpu.gbuffer import GBuffer

TOLERANCE = 0.03  # estimated relative error of luminance up to which a pixel is interpolated
BEND = 2.0  # how many widths of the narrowest lobe the normals of neighbours may differ, so that no highlight hides between
COARSE_UNIT = 5
LIST_BINDING = COLOR_IMAGE = 0


class AdaptiveRate:
    """Runs a method for every second pixel of every second row, and for the pixels where that is not enough.

    Between its shaded neighbours a pixel is interpolated by cubics; second differences, and how far its own normal
    (known everywhere) lies from where theirs put it, estimate the error. Above `tolerance` it is shaded itself, as it is
    at edges. docs/direct.md says what the error is in fact.
    """

    def __init__(self, ctx: moderngl.Context, tolerance: float = TOLERANCE):
        self.ctx, self.tolerance = ctx, tolerance
        self._cover = shader.program(ctx, "passes/picture/screen.vert", "passes/picture/adaptive_cover.frag")
        self._fill = shader.program(ctx, "passes/picture/screen.vert", "passes/picture/adaptive_fill.frag")
        self._buffer: GBuffer | None = None
        self._things: list = []

    def shade(self, buffer: GBuffer, program, list_program, narrowest_lobe: float) -> None:
        """Shade the covered pixels of a G-buffer into its colour target, as `GBuffer.shade` does at the full rate.

        Parameters
        ----------
        program, list_program : shade.frag and shade_list.comp of passes/picture with one method, bound to its data
        narrowest_lobe : gamma, radians
        """
        for _ in self.steps(buffer, program, list_program, narrowest_lobe, lambda _: None):
            pass

    def steps(
        self,
        buffer: GBuffer,
        program,
        list_program,
        narrowest_lobe: float,
        bind: Callable[[object], None],
        rows: Callable[[], int] | None = None,
    ) -> Iterator[None]:
        """As `shade`, a part at a time, for a caller with other things to do in between.

        Parameters
        ----------
        bind : binds a program's data again, after others may have drawn
        rows : called before each part: how many rows' worth of pixels it may shade; None: all
        """
        self._make(buffer)
        self._cover["pixel_stride"].value = 2
        buffer.bind(self._cover)
        # The screen triangle lies at depth 1: it passes `>` at depth 0, and early depth testing drops the other pixels.
        self._draw(self._cover, self._coarse, moderngl.DEPTH_TEST, "1", True)
        first, height = 0, self._coarse.size[1]
        while first < height:
            # A coarse row has half the pixels of a row.
            count = height if rows is None else max(1, min(2 * rows(), height - first))
            bind(program)
            buffer.bind(program)
            program["pixel_stride"].value = 2
            self._coarse.scissor = None if rows is None else (0, first, self._coarse.size[0], count)
            self._draw(program, self._coarse, moderngl.DEPTH_TEST, ">", False)
            self._coarse.scissor = None
            program["pixel_stride"].value = 1
            first += count
            if rows is not None:
                self.ctx.finish()
                yield
        self._list.write(np.array([0, 1, 1, 0], "u4").tobytes())
        self._list.bind_to_storage_buffer(LIST_BINDING)
        self._color.use(COARSE_UNIT)
        buffer.bind(self._fill)
        self._fill["tolerance"].value = self.tolerance
        self._fill["bend_limit"].value = BEND * narrowest_lobe
        self._draw(self._fill, buffer.target, moderngl.DEPTH_TEST, ">", False)
        self.ctx.memory_barrier(moderngl.ALL_BARRIER_BITS)
        if rows is None:
            self._shade_list(buffer, list_program)
            yield
            return
        left, done = self.shaded(), 0
        yield
        while done < left:
            count = min(max(64, rows() * buffer.size[0] // 64 * 64), left - done)
            bind(list_program)
            self._shade_list(buffer, list_program, done, count)
            self.ctx.finish()
            done += count
            yield

    def _shade_list(self, buffer: GBuffer, program, first: int = 0, count: int | None = None) -> None:
        """Shade the pixels of the list, or `count` of them from the `first` on."""
        self._list.bind_to_storage_buffer(LIST_BINDING)
        buffer.bind(program)
        buffer.color.bind_to_image(COLOR_IMAGE, read=False, write=True)
        program["first"].value = first
        if count is None:
            program.run_indirect(self._list)
        else:
            program.run(-(-count // 64))
        self.ctx.memory_barrier(moderngl.ALL_BARRIER_BITS)
        buffer.target.use()

    def shaded(self) -> int:
        """How many pixels the last call shaded beyond one in four."""
        return int(np.frombuffer(self._list.read(16), "u4")[3])

    def _draw(self, program, target: moderngl.Framebuffer, flags: int, depth_func: str, write_depth: bool) -> None:
        target.use()
        target.viewport = (0, 0, *target.size)
        target.depth_mask = write_depth
        self.ctx.enable_only(flags)
        self.ctx.depth_func = depth_func
        array = self.ctx.vertex_array(program, [])
        array.render(moderngl.TRIANGLES, vertices=3)
        array.release()
        self.ctx.depth_func = "<"
        self.ctx.enable_only(moderngl.NOTHING)

    def _make(self, buffer: GBuffer) -> None:
        if self._buffer is buffer:
            return
        self.release()
        width, height = buffer.size
        size = (width // 2 + 1, height // 2 + 1)  # so that the last pixel has a neighbour on either side
        self._buffer = buffer
        self._color = self.ctx.texture(size, 4, dtype="f4")
        self._color.filter = moderngl.NEAREST, moderngl.NEAREST
        self._depth = self.ctx.depth_texture(size)
        self._coarse = self.ctx.framebuffer([self._color], self._depth)
        self._list = self.ctx.buffer(reserve=16 + 4 * width * height)
        self._things = [self._coarse, self._color, self._depth, self._list]

    def release(self) -> None:
        """Free what belongs to the last G-buffer."""
        if self._things:
            # moderngl binds the last framebuffer back after making a new one; it must not be one of those deleted here.
            self.ctx.detect_framebuffer(0).use()
        for thing in self._things:
            thing.release()
        self._things, self._buffer = [], None
