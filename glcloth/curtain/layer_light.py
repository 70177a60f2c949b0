"""Two curtains for radiosity: to the room they are one sheet, but what lies between them lights the inner side of each.   [own]

What each does alone is found by paths among its folds, as for one. The light between them is then a sum over the ways to and fro,
cell by cell; see passes/curtain/layer_texels.comp.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import moderngl
import numpy as np

from ..accel.triangles import Triangles
from ..gpu.buffers import TextureBuffer
from ..gpu.memo import Last
from ..gpu.programs import programs
from ..tracing.fabrics import NOWHERE
from ..tracing.shot import Shot
from .folds import Folds, HangingCloth
from .form_factors import CELLS, Sheet


class HangingPiece(NamedTuple):
    """A piece of cloth: rows and columns of its quads, how far its middle is off the sheet's, and how wide it is, in sheets."""

    rows: int
    columns: int
    shift: float = 0.0
    width: float = 1.0


class CurtainLayers:
    """The front curtain and the one behind it."""

    def __init__(self, ctx: moderngl.Context, sheet: Sheet, each: Sequence[Triangles], pieces: Sequence[HangingPiece]):
        """each : triangles of either as it hangs without wind, released with this. pieces : of both, as Radiosity takes them"""
        self.ctx = ctx
        self.cloths = [HangingCloth(ctx, triangles, sheet) for triangles in each]
        self._begin = each[0].count  # of the one behind, among the triangles of both
        self._folds: Last[list[Folds]] = Last()

    def find(self, inputs: Mapping[str, Any], shot: Shot, fabrics: str) -> None:
        """Find what each does alone. inputs : as of HangingCloth.folds, for both. fabrics : what tells them from others"""
        lamp = shot.lighting.lamp
        self._folds.get(lambda: self._find(inputs), fabrics, lamp.position, lamp.intensity)

    def _find(self, inputs: Mapping[str, Any]) -> list[Folds]:
        out = []
        for cloth, begins in zip(self.cloths, (NOWHERE, 0), strict=True):
            own = {**inputs, "fabric_from": [begins] + [NOWHERE] * 3}
            out.append(cloth.folds(own, np.arange(0, cloth.triangles.count, max(1, cloth.triangles.count // 2000))))
        return out

    @property
    def folds(self) -> list[Folds]:
        """Of each; `find` finds them."""
        assert self._folds.value is not None, "call find first"
        return self._folds.value

    def samples(self, cells: Sequence[np.ndarray], first: int, listed: int) -> tuple[np.ndarray, np.ndarray]:
        """The lists of passes/curtain/sources.comp for the front and the back of each curtain's cells, and what they list.

        cells : triangles of each cell, of both curtains, whose light lies in their order from `first` on. listed : entries before
        """
        lists, entries, at = np.zeros((4 * CELLS, 2), np.uint32), [], listed
        begins = first + np.concatenate([[0], np.cumsum([len(cell) for cell in cells])])
        for curtain in (0, 1):
            for k, cell in enumerate(cells):
                own = np.flatnonzero((cell >= self._begin) == bool(curtain))
                rows = np.zeros((len(own), 2), np.uint32)
                rows[:, 0] = begins[k] + own
                rows[:, 1] = np.full(len(own), 1.0 / max(len(own), 1), np.float32).view(np.uint32)
                for side in (0, 1):
                    lists[(2 * curtain + side) * CELLS + k] = at, len(own)
                entries.append(rows)
                at += len(own)
        return lists, np.concatenate(entries)

    def lamp_shares(self) -> np.ndarray:
        """What each side of each cell sends of the lamp's light on it, [4 CELLS, 3]."""
        return np.repeat(np.concatenate([folds.lamp for folds in self.folds]), CELLS, 0)

    def light(
        self, buffers: Mapping[str, TextureBuffer], first_texel: int, first_receiver: int, first_source: int
    ) -> None:
        """Write the texels of both."""
        front, behind = self.folds
        seen = [folds.seen() for folds in self.folds]
        programs(self.ctx).compute("passes/curtain/layer_texels.comp").run(
            12 * CELLS, {name: np.concatenate([np.asarray(one[name], "f4") for one in seen]) for name in seen[0]},
            received=buffers["received"], sources=buffers["sources"], Texels=buffers["light_texels"], first_texel=first_texel,
            texel_count=12 * CELLS, first_receiver=first_receiver, cell_count=CELLS, first_source=first_source,
            through=np.array([front.passes + front.transmitted[1], behind.passes + behind.transmitted[0]], "f4"),
            back=np.array([front.reflected[1], behind.reflected[0]], "f4"),
        )  # fmt: skip

    def release(self) -> None:
        """Free the GPU's memory."""
        for cloth in self.cloths:
            cloth.release()
