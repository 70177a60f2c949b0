"""Colours of single threads: a pen to paint them with, the colours in use, and what a stroke of the pen makes of a weave."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import Any

from imgui_bundle import imgui  # isort: skip
import numpy as np

from ..color import srgb_decode, srgb_encode
from ..fabric import Fabric
from ..weave.loom import Loom
from ..weave.model import COLOR_TO_ALBEDO
from .draft_grid import Cell
from .widgets import tip

SHOWN = 10  # colours in use that have a button
FIRST = (178, 24, 43)  # sRGB codes of the pen at first


class Pen:
    """A colour, linear Rec. 709 as drafts have it, and the buttons that change it."""

    def __init__(self) -> None:
        self.color = srgb_decode(np.array(FIRST) / 255.0)

    def draw(self, fabric: Fabric, scale: float) -> None:
        """The pen and the colours in use, which it takes up at a click."""
        flags = imgui.ColorEditFlags_
        code = [float(c) for c in srgb_encode(self.color)]
        plain = flags.float | flags.no_inputs | flags.no_label
        changed, code = imgui.color_edit3("##pen", code, plain)
        tip("the pen: drag it along the strips of colours, under the threading and beside the treadling")
        if changed:
            self.color = srgb_decode(np.clip(code, 0.0, 1.0))
        for number, used in enumerate(in_use(fabric)):
            imgui.same_line(0.0, (10.0 if number == 0 else 3.0) * scale)
            shown = imgui.ImVec4(*(float(c) for c in srgb_encode(used)), 1.0)
            if imgui.color_button(f"##used {number}", shown, flags.no_tooltip, (18 * scale, 18 * scale)):
                self.color = used
            tip("a colour of these threads; click to take it up")
        imgui.same_line(0.0, 8 * scale)
        imgui.text("pen")


def thread_colors(fabric: Fabric) -> tuple[np.ndarray, np.ndarray]:
    """Colours of the ends and of the picks in order [n, 3], cyclic, linear Rec. 709 as drafts state them."""
    weave = fabric.weave
    assert weave is not None
    own = weave.thread_colors or tuple(np.array([yarn.albedo]) for yarn in fabric.yarn)
    warp, weft = (np.clip(np.asarray(c, float) / COLOR_TO_ALBEDO, 0.0, 1.0) for c in own)
    return warp, weft


def in_use(fabric: Fabric) -> list[np.ndarray]:
    """The different colours of the threads, those of the warp first."""
    codes = np.rint(255.0 * srgb_encode(np.concatenate(thread_colors(fabric)))).astype(int)
    return [srgb_decode(np.array(code) / 255.0) for code in dict.fromkeys(map(tuple, codes.tolist()))][:SHOWN]


def color_of(fabric: Fabric, cell: Cell) -> np.ndarray:
    """The colour of the thread of a cell on the strips."""
    warp, weft = thread_colors(fabric)
    return warp[cell.column % len(warp)] if cell.part == "warp" else weft[cell.row % len(weft)]


def painted(fabric: Fabric, loom: Loom, cells: Iterable[Cell], color: np.ndarray) -> tuple[dict[str, Any], Loom]:
    """Fields of the weave after threads of the grid have got a colour, and the loom on the grid, which then shows a whole
    repeat of the colours.

    loom : what is on the grid, whole repeats of the weave's draft. cells : on the strips. color : as drafts have it
    """
    weave = fabric.weave
    assert weave is not None
    own = thread_colors(fabric)
    picks, ends = loom.drawdown.shape
    loom = loom.resized(int(np.lcm(picks, len(own[1]))), int(np.lcm(ends, len(own[0]))))
    draft = loom.draft(weave.drafted)
    warp, weft = np.resize(own[0], (draft.ends, 3)), np.resize(own[1], (draft.picks, 3))
    for cell in cells:
        if cell.part == "warp":
            warp[cell.column] = color
        else:
            weft[cell.row] = color
    draft = replace(draft, warp_colors=warp, weft_colors=weft).reduced()
    return {"draft": draft, "colors": "draft", "warp_stripes": None, "weft_stripes": None}, loom
