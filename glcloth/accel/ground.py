"""A plane without end under a hierarchy of triangles: it needs no triangles, and no traversal where it hides the light."""

from __future__ import annotations

from typing import Any

from .structure import Traced
from .triangles import Triangles


class OverGround:
    """An lbvh and the plane y = height, which is met from both sides; to passes that trace it is one structure.

    A hit on the plane has the number GROUND of trace/ground.glsl.
    """

    source = "inputs/accel/lbvh_ground.glsl"
    ordered_hits = False

    def __init__(self, structure: Traced, height: float):
        self._structure, self.height = structure, float(height)
        self.chunks = structure.chunks

    def inputs(self) -> dict[str, Any]:
        """The inputs of inputs/accel/lbvh_ground.glsl, by name."""
        return self._structure.inputs() | {"ground_height": self.height}

    @property
    def triangles(self) -> Triangles | None:
        """The triangles that the structure was built of."""
        return self._structure.triangles
