"""A kd-tree of points, such as photons, by the builder of triangles' trees; passes ask it for nearest neighbours.

[Zhou, Hou, Wang, Guo 2008, sections 3 and 4.2]   A point's box is the point, so nothing is cut and no point lies in two leaves.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, ClassVar

import numpy as np

from ..gpu.buffers import TextureBuffer
from .kdtree import BUFFERS, KdTree
from .triangles import PADDING

TEXELS = 2  # of a point: (x, y, z, packed normal) and four numbers that it carries


class PointTree(KdTree):
    """A kd-tree of points on the GPU; `inputs` are those of inputs/accel/nearest_points.glsl."""

    source = "inputs/accel/nearest_points.glsl"
    buffers = {name: kind for name, kind in BUFFERS.items() if "Leaf" not in name} | {
        "leaf_pairs LeafPairs": ("leaf", 1, "r32ui"),
        "leaf_points LeafPoints": ("leaf", TEXELS, "rgba32ui"),
    }
    begin_pass, leaves_pass = "passes/accel/kdtree_points.comp", "passes/accel/kdtree_point_leaves.comp"
    at_first: ClassVar[Mapping[str, float]] = {"node": 1.1, "ref": 1.0, "leaf": 1.0}

    step_cost = 8.0  # of leaves of sixteen points at most
    point_count = 0

    def sort(self, points: TextureBuffer, count: int, scale: float) -> Iterator[None]:
        """Build the tree of the first `count` points of a buffer, in steps. scale : their largest coordinate, m."""
        self.point_count, self.margin = count, scale * PADDING
        # Scattering asks for the corners of what a plane cuts, and never finds any.
        yield from self._steps(count, {"points": points, "corners": points}, 0.0)

    @property
    def sorted_points(self) -> TextureBuffer:
        """The points in the order of the leaves, so that neighbours in it are near each other."""
        return self._buffers["leaf_points"]

    def inputs(self) -> dict[str, Any]:
        """By their names in GLSL."""
        return {"point_nodes": self._buffers["tree_nodes"], "leaf_points": self.sorted_points}

    def positions(self) -> np.ndarray:
        """Read the points back in the order of the leaves: float32 [N, 3]."""
        raw = self.sorted_points.read(16 * TEXELS * self.point_count)
        return np.ascontiguousarray(np.frombuffer(raw, np.float32).reshape(-1, TEXELS, 4)[:, 0, :3])
