"""Shading at an adaptive rate: one pixel in four, and those others that their neighbours do not determine.   [own]

Where pixels show threads, what each tangent adds is found for one pixel in sixteen, and for one in four where that is not
enough; threads are drawn over it at every pixel.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import moderngl
import numpy as np

from ..gpu.buffers import Buffer, read_texture
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
    terms_program : inputs/picture/shade_terms.glsl with the method, for one pixel in sixteen or in four
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
        limits: dict[str, Any] = {
            "tolerance": self.tolerance,
            "bend_limit": BEND * narrowest_lobe,
            "coarse": self._color,
            "coarse_stride": 2,
        }
        if shown is not None:
            yield from self._near_terms(buffer, shown, inputs, pace, limits)
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
            Pixels=self._near_list, terms=self._terms, wide_row=self._wide_row, smooth_blocks=self._smooth,
            far_depth=shown.far.depth_attachment, **limits,
        )  # fmt: skip
        self.ctx.memory_barrier()
        every: Callable[[], Inputs] = lambda: {**inputs(), **shown.inputs()}  # noqa: E731
        yield from self._shade_list(buffer, shown.list_program, self._near_list, every, pace)

    def _cover(
        self, buffer: GBuffer, part: moderngl.Framebuffer | None, stride: int = 2, by_blocks: bool = False
    ) -> None:
        """Cover the coarse pixels that sample a covered pixel, of a part of the picture or of all; make all of them black.

        `by_blocks`: only those beside blocks that are not smooth, and none becomes black.
        """
        defines = {} if part is None else {"OF_A_PART": 1}
        cover = programs(self.ctx).screen(
            "passes/picture/adaptive_cover.frag", {**defines, "OF_BLOCKS": 1} if by_blocks else defines
        )
        inputs = buffer.inputs() if part is None else {"part_depth": part.depth_attachment}
        own = {"pixel_stride": stride, **({"smooth_blocks": self._smooth} if by_blocks else {})}
        target = self._coarse if stride == 2 else self._wide
        target.color_mask = (not by_blocks,) * 4
        draw_screen(cover, target, inputs, own, depth="written")
        target.color_mask = (True,) * 4

    def _near_terms(
        self, buffer: GBuffer, shown: Shown, inputs: Callable[[], Inputs], pace: Pace, limits: Inputs
    ) -> Iterator[None]:
        """Shade coarse pixels that show threads as cloth from afar, and keep the tangents' terms: every fourth of every
        fourth row, then every second of every second beside blocks between those that are not smooth."""
        if self._terms is None or self._terms.layers < shown.layers:
            if self._terms is not None:
                self._terms.release()
            size = max(self._coarse.width, self._wide.width), self._wide_row + self._wide.height
            self._terms = self.ctx.texture_array((*size, shown.layers), 4, dtype="f2")
            # With 0 no weight of 0 makes a value that is no number. A layer at a time: together they may take gigabytes.
            nothing = bytes(8 * size[0] * size[1])
            for layer in range(shown.layers):
                self._terms.write(nothing, (0, 0, layer, *size, 1))
            self._terms.filter = moderngl.LINEAR, moderngl.LINEAR
            self._terms.repeat_x = self._terms.repeat_y = False
        self._cover(buffer, shown.near, 4)
        yield from self._keep_terms(buffer, shown, inputs, pace, 4)
        wide = {**limits, "coarse": self._wide_color, "coarse_stride": 4}
        blocks = programs(self.ctx).screen("passes/picture/adaptive_blocks.frag")
        draw_screen(blocks, self._blocks, buffer.inputs(), wide, near_depth=shown.near.depth_attachment)
        self._cover(buffer, shown.near, by_blocks=True)
        yield from self._keep_terms(buffer, shown, inputs, pace, 2)
        between = programs(self.ctx).screen("passes/picture/adaptive_between.frag")
        draw_screen(between, self._coarse, buffer.inputs(), wide, smooth_blocks=self._smooth)
        self.ctx.memory_barrier()

    def _keep_terms(
        self, buffer: GBuffer, shown: Shown, inputs: Callable[[], Inputs], pace: Pace, stride: int
    ) -> Iterator[None]:
        target, row = (self._coarse, 0) if stride == 2 else (self._wide, self._wide_row)
        for band in pace.bands(target.height, stride):
            own = {"terms": self._terms, "terms_row": row, "terms_stride": stride}
            given = inputs(), shown.inputs(), buffer.inputs(), own
            self._covered.shade(shown.terms_program, target, *given, key=None, rows=band)
            yield from pace.pause(self.ctx)

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
        """How many pixels the last call shaded beyond those of the coarse pictures."""
        return _length(self._list) + _length(self._near_list)

    def smooth(self) -> float:
        """The share of blocks of 4 x 4 pixels of which the last call knew the terms of threads from their corners."""
        return float((np.frombuffer(read_texture(self._smooth), "u1") > 0).mean())

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
        # For threads, one in sixteen likewise, and which blocks between them are smooth.
        wide = size[0] // 4 + 2, size[1] // 4 + 2
        self._wide_row = coarse[1] + 1  # of the texture of terms
        self._wide_color = self.ctx.texture(wide, 4, dtype="f4")
        self._wide_color.filter = moderngl.NEAREST, moderngl.NEAREST
        self._wide_depth = depth_texture(self.ctx, wide)
        self._wide = self.ctx.framebuffer([self._wide_color], self._wide_depth)
        self._smooth = self.ctx.texture((wide[0] - 1, wide[1] - 1), 1)
        self._smooth.filter = moderngl.NEAREST, moderngl.NEAREST
        self._blocks = self.ctx.framebuffer([self._smooth])

    def release(self) -> None:
        """Free the coarse picture."""
        if self._size is None:
            return
        # moderngl binds the last framebuffer back after making a new one; it must not be one of those deleted here.
        self.ctx.detect_framebuffer(0).use()
        if self._terms is not None:
            self._terms.release()
            self._terms = None
        for thing in (
            self._coarse, self._color, self._depth, self._wide, self._wide_color, self._wide_depth, self._blocks,
            self._smooth,
        ):  # fmt: skip
            thing.release()
        self._size = None


def _length(listed: Buffer) -> int:
    """How many pixels a list holds."""
    return int(np.frombuffer(listed.read(16), "u4")[3])
