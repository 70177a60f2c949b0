"""The one full-screen draw: a fragment pass over a framebuffer, all of it or where something was drawn."""

from __future__ import annotations

from typing import Any, Literal

import moderngl

from .programs import Draw, Inputs

Blend = Literal["replace", "add", "behind"]


def draw_screen(
    program: Draw,
    target: moderngl.Framebuffer,
    *inputs: Inputs,
    blend: Blend = "replace",
    covered: bool = False,
    rows: tuple[int, int] | None = None,
    **own: Any,
) -> None:
    """Run a program of passes/picture/screen.vert over a framebuffer; the names are bound as by `Program.bind`.

    Parameters
    ----------
    blend : "replace" what is there, "add" to it, or go "behind" it, by what its alpha leaves uncovered
    covered : only the pixels where the framebuffer's depth holds something nearer than the far plane; the screen
        triangle lies on that plane, so early depth testing drops the others before they are shaded
    rows : (first, count), counted from below: only this band
    """
    ctx = target.ctx
    program.bind(*inputs, **own)
    # moderngl's types forget that None is no scissor.
    target.scissor = None if rows is None else (0, rows[0], target.width, rows[1])  # type: ignore[assignment]
    target.use()
    target.viewport = (0, 0, target.width, target.height)
    if covered:
        target.depth_mask = False
    ctx.enable_only((moderngl.DEPTH_TEST if covered else 0) | (0 if blend == "replace" else moderngl.BLEND))
    ctx.blend_func = (moderngl.ONE, moderngl.ONE) if blend == "add" else (moderngl.ONE_MINUS_DST_ALPHA, moderngl.ONE)
    if covered:
        ctx.depth_func = ">"
    program.screen.render(moderngl.TRIANGLES, vertices=3)
    ctx.depth_func = "<"
    ctx.enable_only(moderngl.NOTHING)
    target.scissor = None  # type: ignore[assignment]
