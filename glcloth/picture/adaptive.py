"""Shading at an adaptive rate: one pixel in four, and those others that their neighbours do not determine.   [own]"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import moderngl
import numpy as np

from ..gpu.buffers import Buffer
from ..gpu.covered import Covered
from ..gpu.gbuffer import GBuffer, depth_texture
from ..gpu.programs import Compute, Draw, Inputs, programs
from ..gpu.screen import draw_screen
from .pace import Pace

TOLERANCE = 0.03  # estimated relative error of luminance up to which a pixel is interpolated
EMPTY = np.array([0, 1, 1, 0], "u4")  # a list of pixels
BEND = 2.0  # how many widths of the narrowest lobe the normals of neighbours may differ, so that no highlight hides between


@dataclass(frozen=True)
class Shown:
    """The pixels that show threads, and what shades them.

    Parameters
    ----------
    near, far : the picture, where only these pixels are covered, and only the others
    terms_program : shade_terms of passes/picture with the method, for one pixel in four
    layers : texels that this keeps of each
    list_program : as for the other pixels
    defines, virtual : of the program that combines terms with the maps of threads
    inputs : what these programs read beside the inputs of the others
    """

    near: moderngl.Framebuffer
    far: moderngl.Framebuffer
    terms_program: Draw | Compute
    layers: int
    list_program: Compute
    defines: dict[str, Any]
    virtual: dict[str, str]
    inputs: Callable[[], Inputs]


class AdaptiveRate:
    """Runs a method for every second pixel of every second row, and for the pixels where that is not enough.

    Between its shaded neighbours a pixel is interpolated by cubics; second differences, and how far its own normal
    (known everywhere) lies from where theirs put it, estimate the error. Above `tolerance` it is shaded itself, as it is
    at edges. docs/direct.md has the measured error.
    """

    def __init__(self, ctx: moderngl.Context, tolerance: float = TOLERANCE):
        self.ctx, self.tolerance = ctx, tolerance
        self._size: tuple[int, int] | None = None
        self._list, self._near_list = Buffer(ctx, 16), Buffer(ctx, 16)
        self._covered = Covered(ctx)
        self._terms: moderngl.TextureArray | None = None

    def steps(
        self,
        buffer: GBuffer,
        program: Draw | Compute,
        list_program: Compute,
        narrowest_lobe: float,
        inputs: Callable[[], Inputs],
        pace: Pace,
        shown: Shown | None = None,
    ) -> Iterator[None]:
        """Shade the covered pixels of a G-buffer into its colour target, as `GBuffer.shade` does at the full rate.

        Parameters
        ----------
        program, list_program : what shades a pixel, and shade_list.comp of passes/picture, with one method
        narrowest_lobe : gamma, radians
        inputs : of both
        shown : the pixels that show threads
        """
        self._reserve(buffer.size)
        self._cover(buffer, None if shown is None else shown.far)
        # A coarse row has half the pixels of a row.
        for band in pace.bands(self._coarse.height, 2):
            own = {"pixel_stride": 2, "pass_weight": 1.0, "pass_cover": 1.0}
            self._covered.shade(program, self._coarse, inputs(), buffer.inputs(), own, key=None, rows=band)
            yield from pace.pause(self.ctx)
        if shown is not None:
            yield from self._near_terms(buffer, shown, inputs, pace)
        limits: dict[str, Any] = {
            "tolerance": self.tolerance,
            "bend_limit": BEND * narrowest_lobe,
            "coarse": self._color,
        }
        fill = programs(self.ctx).screen("passes/picture/adaptive_fill.frag")
        for one in (self._list, self._near_list):
            one.write(EMPTY)
        target = buffer.target if shown is None else shown.far
        draw_screen(fill, target, buffer.inputs(), depth="covered", Pixels=self._list, **limits)
        self.ctx.memory_barrier()
        yield from self._shade_list(buffer, list_program, self._list, inputs, pace)
        if shown is None:
            return
        fill = programs(self.ctx).screen("passes/picture/adaptive_fill.frag", shown.defines, shown.virtual)
        draw_screen(
            fill, shown.near, buffer.inputs(), inputs(), shown.inputs(), depth="covered",
            Pixels=self._near_list, terms=self._terms, far_depth=shown.far.depth_attachment, **limits,
        )  # fmt: skip
        self.ctx.memory_barrier()
        every: Callable[[], Inputs] = lambda: {**inputs(), **shown.inputs()}  # noqa: E731
        yield from self._shade_list(buffer, shown.list_program, self._near_list, every, pace)

    def _cover(self, buffer: GBuffer, part: moderngl.Framebuffer | None, clears: bool = True) -> None:
        """Cover the coarse pixels that sample a covered pixel, of a part of the picture or of all; make all of them black."""
        cover = programs(self.ctx).screen(
            "passes/picture/adaptive_cover.frag", {} if part is None else {"OF_A_PART": 1}
        )
        inputs = buffer.inputs() if part is None else {"part_depth": part.depth_attachment}
        self._coarse.color_mask = (clears,) * 4
        draw_screen(cover, self._coarse, inputs, depth="written", pixel_stride=2)
        self._coarse.color_mask = (True,) * 4

    def _near_terms(self, buffer: GBuffer, shown: Shown, inputs: Callable[[], Inputs], pace: Pace) -> Iterator[None]:
        """Shade the coarse pixels that show threads as cloth from afar, and keep the tangents' terms."""
        if self._terms is None or self._terms.layers != shown.layers:
            if self._terms is not None:
                self._terms.release()
            self._terms = self.ctx.texture_array((*self._coarse.size, shown.layers), 4, dtype="f2")
            self._terms.filter = moderngl.LINEAR, moderngl.LINEAR
            self._terms.repeat_x = self._terms.repeat_y = False
        self._cover(buffer, shown.near, clears=False)
        for band in pace.bands(self._coarse.height, 2):
            given = inputs(), shown.inputs(), buffer.inputs(), {"terms": self._terms}
            self._covered.shade(shown.terms_program, self._coarse, *given, key=None, rows=band)
            yield from pace.pause(self.ctx)
        self.ctx.memory_barrier()

    def _shade_list(
        self, buffer: GBuffer, list_program: Compute, listed: Buffer, inputs: Callable[[], Inputs], pace: Pace
    ) -> Iterator[None]:
        """Shade the pixels of a list."""
        values = {"Pixels": listed, "color": buffer.color}
        most = list_program.group_size[0] * programs(self.ctx).most_groups  # that one dispatch takes
        if pace.rows is None and buffer.size[0] * buffer.size[1] <= most:
            list_program.run_indirect(listed, inputs(), buffer.inputs(), values, first=0)
            yield
            return
        left, done = _length(listed), 0
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
        return _length(self._list) + _length(self._near_list)

    def _reserve(self, size: tuple[int, int]) -> None:
        """Make the coarse picture of a size."""
        for one in (self._list, self._near_list):
            one.reserve(16 + 4 * size[0] * size[1])
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
        if self._terms is not None:
            self._terms.release()
            self._terms = None
        for thing in (self._coarse, self._color, self._depth):
            thing.release()
        self._size = None


def _length(listed: Buffer) -> int:
    """How many pixels a list holds."""
    return int(np.frombuffer(listed.read(16), "u4")[3])
