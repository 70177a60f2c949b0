"""No structure at all: every ray meets every triangle. Slow, and right by its simplicity."""

from __future__ import annotations

import numpy as np

from .triangles import Triangles

CHUNK = 16_384  # triangles of one dispatch; loops may end silently after 65,535


class Brute:
    """The judge of the other structures, behind the same interface."""

    name = "brute"
    source = "inputs/accel/brute.glsl"
    settles = False

    def __init__(self, ctx):
        self.ctx = ctx
        self.timings: dict[str, float] = {}
        self.node_count = self.leaf_ref_count = 0
        self._triangles: Triangles | None = None

    def build(self, triangles: Triangles) -> None:
        """Remember the triangles."""
        self._triangles = triangles

    def bind(self, program) -> None:
        """Bind what inputs/accel/brute.glsl reads."""
        self._triangles.corners.bind(8)
        self._triangles.attributes.bind(9)

    def chunks(self):
        """The uniforms of each dispatch that one query takes."""
        for first in range(0, max(self._triangles.count, 1), CHUNK):
            yield {
                "first_test": first,
                "test_count": min(CHUNK, self._triangles.count - first),
                "resume": int(first > 0),
            }

    def arrays(self) -> dict[str, np.ndarray]:
        """One leaf with all triangles."""
        count = self._triangles.count
        return {
            "axis": np.array([3]),
            "count": np.array([count]),
            "triangles": np.arange(count),
            "depth": np.array([0]),
        }

    def release(self) -> None:
        """Nothing to free."""
