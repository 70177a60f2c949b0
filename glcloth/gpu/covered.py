"""Shading the covered pixels of a framebuffer: by a draw, or in compute, which on some GPUs is many times as fast.   [own]"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Literal

import moderngl
import numpy as np

from .buffers import Buffer
from .memo import Last
from .programs import Compute, Draw, Inputs, programs
from .screen import draw_screen

Way = Literal["fragment", "compute"]
GROUPS_OF_A_ROW = 16  # as passes/picture/covered_list.comp has it
EMPTY = np.array([GROUPS_OF_A_ROW, 0, 1, 0], "u4")
# That are listed at a time: a block of storage may have no more than 128 MB on some devices, and a dispatch no more than 65,535
# rows of work groups.
MOST_PIXELS = 1 << 24


def shading(ctx: moderngl.Context, file: str, defines: Inputs, virtual: Mapping[str, str], way: Way) -> Draw | Compute:
    """The program that shades pixels, for `Covered.shade`; other parameters as for `Programs.compute`.

    `file`: one of inputs/picture/shade_*.glsl, which says how
    """
    virtual = {**virtual, "shade.glsl": file}
    if way == "fragment":
        return programs(ctx).screen("passes/picture/covered.frag", defines, virtual)
    return programs(ctx).compute("passes/picture/covered.comp", defines, virtual)


class Covered:
    """The covered pixels of one framebuffer; compute passes have a list of them, which stays until the key changes."""

    def __init__(self, ctx: moderngl.Context):
        self.ctx = ctx
        self._list: Buffer | None = None
        self._listed: Last[None] = Last()

    def shade(
        self,
        program: Draw | Compute,
        target: moderngl.Framebuffer,
        *inputs: Inputs,
        key: Any,
        add: bool = False,
        rows: tuple[int, int] | None = None,
    ) -> None:
        """Run a program for every pixel that a framebuffer's depth covers; both kinds of program do the same.

        Parameters
        ----------
        key : of which pixels are covered; None: they are other ones each time
        add : the colours to the present picture, instead of setting them
        rows : (first, count), counted from below: only this band
        """
        if isinstance(program, Draw):
            blend: Literal["add", "replace"] = "add" if add else "replace"
            draw_screen(program, target, *inputs, blend=blend, depth="covered", rows=rows)
            return
        first, count = rows or (0, target.height)
        most = max(8, MOST_PIXELS // target.width // 8 * 8)
        for low in range(first, first + count, most):
            band = low, min(low + most, first + count)
            listed = self._pixels(target, band, key)
            images = dict(
                zip(("target_color", "target_bounce", "target_through"), target.color_attachments, strict=False)
            )
            program.run_indirect(listed, *inputs, images, Covered=listed, adds=add)

    def _pixels(self, target: moderngl.Framebuffer, band: tuple[int, int], key: Any) -> Buffer:
        """The list of those in a band of rows."""
        if self._list is None:
            self._list = Buffer(self.ctx, 16)
        if key is None or self._listed.changes(band, key):
            self._list.reserve(16 + 4 * target.width * (band[1] - band[0]))
            self._list.write(EMPTY)
            items = target.width, band[1] - band[0]
            depth = target.depth_attachment
            programs(self.ctx).compute("passes/picture/covered_list.comp").run(
                items, covered_depth=depth, band=band, Covered=self._list
            )
        return self._list

    def release(self) -> None:
        """Free the GPU's memory."""
        if self._list is not None:
            self._list.release()
