"""A plane without end under a hierarchy of triangles: it needs no triangles, and no traversal where it hides the light."""

from __future__ import annotations

from typing import Any

from ..gpu.buffers import Buffer
from .structure import Structure
from .triangles import Triangles


class OverGround:
    """An lbvh and the plane y = height, which is met from both sides; to passes that trace it is one structure.

    A hit on the plane has the number GROUND of trace/ground.glsl.
    """

    source = "inputs/accel/lbvh_ground.glsl"
    ordered_hits = False

    def __init__(self, structure: Structure, height: float):
        self.structure, self.height = structure, float(height)
        self.build, self.build_steps = structure.build, structure.build_steps
        self.fits = structure.fits
        self.chunks, self.arrays, self.release = structure.chunks, structure.arrays, structure.release

    def inputs(self) -> dict[str, Any]:
        """The inputs of inputs/accel/lbvh_ground.glsl, by name."""
        return self.structure.inputs() | {"ground_height": self.height}

    @property
    def unread(self) -> Buffer | None:
        """Of the structure."""
        return self.structure.unread

    @property
    def triangles(self) -> Triangles | None:
        """The triangles that the structure was built of."""
        return self.structure.triangles

    @property
    def node_count(self) -> int:
        """Of the structure."""
        return self.structure.node_count

    @property
    def leaf_ref_count(self) -> int:
        """Of the structure."""
        return self.structure.leaf_ref_count

    @property
    def timings(self) -> dict[str, float]:
        """Of the structure's last build."""
        return self.structure.timings
