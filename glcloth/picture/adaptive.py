"""Shading at an adaptive rate: one pixel in four, and those others that their neighbours do not determine.   [own]"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import moderngl
import numpy as np

from ..gpu.buffers import Buffer
from ..gpu.gbuffer import GBuffer, depth_texture
from ..gpu.programs import Compute, Draw, Inputs, programs
from ..gpu.screen import draw_screen
from .pace import Pace

TOLERANCE = 0.03  # estimated relative error of luminance up to which a pixel is interpolated
BEND = 2.0  # how many widths of the narrowest lobe the normals of neighbours may differ, so that no highlight hides between


class AdaptiveRate:
    """Runs a method for every second pixel of every second row, and for the pixels where that is not enough.

    Between its shaded neighbours a pixel is interpolated by cubics; second differences, and how far its own normal
    (known everywhere) lies from where theirs put it, estimate the error. Above `tolerance` it is shaded itself, as it is
    at edges. docs/direct.md has the measured error.
    """

    def __init__(self, ctx: moderngl.Context, tolerance: float = TOLERANCE):
        self.ctx, self.tolerance = ctx, tolerance
        self._size: tuple[int, int] | None = None
        self._list = Buffer(ctx, 16)

    def steps(
        self,
        buffer: GBuffer,
        program: Draw,
        list_program: Compute,
        narrowest_lobe: float,
        inputs: Callable[[], Inputs],
        pace: Pace,
    ) -> Iterator[None]:
        """Shade the covered pixels of a G-buffer into its colour target, as `GBuffer.shade` does at the full rate.

        Parameters
        ----------
        program, list_program : shade.frag and shade_list.comp of passes/picture with one method
        narrowest_lobe : gamma, radians
        inputs : of both
        """
        self._reserve(buffer.size)
        cover = programs(self.ctx).screen("passes/picture/adaptive_cover.frag")
        draw_screen(cover, self._coarse, buffer.inputs(), depth="written", pixel_stride=2)
        # A coarse row has half the pixels of a row.
        for band in pace.bands(self._coarse.height, 2):
            draw_screen(
                program, self._coarse, inputs(), buffer.inputs(), depth="covered", rows=band,
                pixel_stride=2, pass_weight=1.0, pass_cover=1.0,
            )  # fmt: skip
            yield from pace.pause(self.ctx)
        self._list.write(np.array([0, 1, 1, 0], "u4"))
        fill = programs(self.ctx).screen("passes/picture/adaptive_fill.frag")
        draw_screen(
            fill, buffer.target, buffer.inputs(), depth="covered",
            coarse=self._color, Pixels=self._list, tolerance=self.tolerance, bend_limit=BEND * narrowest_lobe,
        )  # fmt: skip
        self.ctx.memory_barrier()
        values = {"Pixels": self._list, "color": buffer.color}
        most = list_program.group_size[0] * programs(self.ctx).most_groups  # that one dispatch takes
        if pace.rows is None and buffer.size[0] * buffer.size[1] <= most:
            list_program.run_indirect(self._list, inputs(), buffer.inputs(), values, first=0)
            yield
            return
        left, done = self.shaded(), 0
        yield
        while done < left:
            rows = buffer.size[1] if pace.rows is None else pace.rows()
            count = min(max(64, rows * buffer.size[0] // 64 * 64), left - done, most)
            list_program.run(count, inputs(), buffer.inputs(), values, first=done)
            self.ctx.finish()
            done += count
            yield

    def shaded(self) -> int:
        """How many pixels the last call shaded beyond one in four."""
        return int(np.frombuffer(self._list.read(16), "u4")[3])

    def _reserve(self, size: tuple[int, int]) -> None:
        """Make the coarse picture of a size."""
        self._list.reserve(16 + 4 * size[0] * size[1])
        if self._size == size:
            return
        self.release()
        coarse = size[0] // 2 + 1, size[1] // 2 + 1  # so that the last pixel has a neighbour on either side
        self._size = size
        self._color = self.ctx.texture(coarse, 4, dtype="f4")
        self._color.filter = moderngl.NEAREST, moderngl.NEAREST
        self._depth = depth_texture(self.ctx, coarse)
        self._coarse = self.ctx.framebuffer([self._color], self._depth)

    def release(self) -> None:
        """Free the coarse picture."""
        if self._size is None:
            return
        # moderngl binds the last framebuffer back after making a new one; it must not be one of those deleted here.
        self.ctx.detect_framebuffer(0).use()
        for thing in (self._coarse, self._color, self._depth):
            thing.release()
        self._size = None
