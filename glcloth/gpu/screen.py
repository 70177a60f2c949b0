"""The one full-screen draw: a fragment pass over a framebuffer, all of it or where something was drawn."""

from __future__ import annotations

from typing import Any, Literal

import moderngl

from .programs import Draw, Inputs

Blend = Literal["replace", "add", "behind"]
Depth = Literal["ignored", "covered", "nearest", "written"]
_DEPTH_FUNC = {"covered": ">", "nearest": "<", "written": "1"}


def draw_screen(
    program: Draw,
    target: moderngl.Framebuffer,
    *inputs: Inputs,
    blend: Blend = "replace",
    depth: Depth = "ignored",
    rows: tuple[int, int] | None = None,
    **own: Any,
) -> None:
    """Run a program of passes/picture/screen.vert over a framebuffer; the names are bound as by `Program.bind`.

    Parameters
    ----------
    blend : "replace" what is there, "add" to it, or go "behind" it, by what its alpha leaves uncovered
    depth : "covered": only the pixels where the framebuffer's depth holds something nearer than the program's, which is
        that of the far plane; early depth testing drops the others before they are shaded. "nearest" and "written": the
        program's depth is kept where it is nearer, or everywhere
    rows : (first, count), counted from below: only this band
    """
    ctx = target.ctx
    program.bind(*inputs, **own)
    # moderngl's types forget that None is no scissor.
    target.scissor = None if rows is None else (0, rows[0], target.width, rows[1])  # type: ignore[assignment]
    target.use()
    target.viewport = (0, 0, target.width, target.height)
    target.depth_mask = depth in ("nearest", "written")
    ctx.enable_only((0 if depth == "ignored" else moderngl.DEPTH_TEST) | (0 if blend == "replace" else moderngl.BLEND))
    ctx.blend_func = (moderngl.ONE, moderngl.ONE) if blend == "add" else (moderngl.ONE_MINUS_DST_ALPHA, moderngl.ONE)
    ctx.depth_func = _DEPTH_FUNC.get(depth, "<")
    program.screen.render(moderngl.TRIANGLES, vertices=3)
    ctx.depth_func = "<"
    ctx.enable_only(moderngl.NOTHING)
    target.scissor = None  # type: ignore[assignment]
