"""A cloth that others may not pass: what hangs behind a curtain keeps it out, and pushes it where the wind blows.

One way: what hangs behind moves as if nothing were before it; in strong wind both push each other instead (meeting.py). Over
cells of a plane it is known how far forward it hangs; a step of what hangs before goes from where it hung to where it hangs now.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Protocol

import moderngl
import numpy as np

from ..gpu.buffers import Buffer, TextureBuffer
from ..gpu.programs import programs


class Hanging(Protocol):
    """What is asked of a cloth behind: its vertices, one vec4 each."""

    vertex_count: int
    position_buffer: Buffer


class Backdrop:
    """How far forward (+z) some cloths hang over a rectangle, at the beginning and at the end of a step."""

    def __init__(
        self,
        ctx: moderngl.Context,
        cloths: Sequence[Hanging],
        cell: float,
        low: tuple[float, float],
        high: tuple[float, float],
    ):
        """`cell`: as wide as the cloths' vertices are apart, or wider, m. `low`, `high`: corners of the rectangle in x and y, m;
        beyond it the heights at its edge count."""
        self.ctx, self.cloths, self.low = ctx, tuple(cloths), low
        self.cell = cell
        self.cells = tuple(max(1, int(np.ceil((b - a) / self.cell))) for a, b in zip(low, high, strict=True))
        self._bytes = 4 * self.cells[0] * self.cells[1]
        self._before, self._after = (TextureBuffer(ctx, bytes(self._bytes), "r32ui") for _ in range(2))
        self.take()
        self.take()

    def take(self) -> None:
        """The cloths hang elsewhere now; where they hung before is the beginning of the step."""
        self._before, self._after = self._after, self._before
        self._after.write(bytes(self._bytes))
        for cloth in self.cloths:
            programs(self.ctx).compute("passes/simulation/backdrop.comp").run(
                cloth.vertex_count, self._plane(), Position=cloth.position_buffer, Heights=self._after,
                vertex_count=cloth.vertex_count,
            )  # fmt: skip

    def _plane(self) -> dict[str, Any]:
        return {"backdrop_low": self.low, "backdrop_cell": self.cell, "backdrop_cells": self.cells}

    def inputs(self, share: float) -> dict[str, Any]:
        """What inputs/simulation/backdrop.glsl reads where that share of the step has passed."""
        return {
            **self._plane(), "backdrop_before": self._before, "backdrop_after": self._after, "backdrop_share": share,
        }  # fmt: skip

    def heights(self) -> np.ndarray:
        """Read back how far forward they hang at the end of the step: [rows, columns], m, from below."""
        data = np.frombuffer(self._after.read(self._bytes), np.float32)
        return data.reshape(self.cells[1], self.cells[0]).copy()

    def release(self) -> None:
        """Free the GPU's memory."""
        self._before.release()
        self._after.release()
