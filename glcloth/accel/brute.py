"""No structure at all: every ray meets every triangle. Slow, and right by its simplicity."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import moderngl
import numpy as np

from .triangles import Triangles

CHUNK = 16_384  # triangles of one dispatch; loops may end silently after 65,535


class Brute:
    """The judge of the other structures (glcloth/accel/structure.py)."""

    source = "inputs/accel/brute.glsl"
    ordered_hits = False

    def __init__(self, ctx: moderngl.Context):
        self.timings: dict[str, float] = {}
        self.node_count = self.leaf_ref_count = 0
        self.triangles: Triangles | None = None

    def build(self, triangles: Triangles) -> None:
        """Remember the triangles."""
        self.triangles = triangles

    def build_steps(self, triangles: Triangles, later: bool = False) -> Iterator[None]:
        """As `build`, in one step."""
        self.build(triangles)
        yield

    unread = None

    def fits(self, data: bytes) -> bool:
        """It always does."""
        return True

    @property
    def _built(self) -> Triangles:
        assert self.triangles is not None, "brute: build it first"
        return self.triangles

    def inputs(self) -> dict[str, Any]:
        """The inputs of inputs/accel/brute.glsl, by name."""
        return self._built.inputs()

    def chunks(self) -> Iterator[dict[str, int]]:
        """The uniforms of each dispatch that one query takes."""
        count = self._built.count
        for first in range(0, max(count, 1), CHUNK):
            yield {"first_test": first, "test_count": min(CHUNK, count - first), "resume": int(first > 0)}

    def arrays(self) -> dict[str, np.ndarray]:
        """One leaf with all triangles."""
        count = self._built.count
        numbers = {"axis": [3], "count": [count], "triangles": range(count), "depth": [0]}
        return {name: np.array(values, int) for name, values in numbers.items()}

    def release(self) -> None:
        """Nothing to free."""
