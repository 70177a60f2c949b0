"""Where rays between surfaces can end: the triangles and vertices of all of them in one numbering, on the GPU."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import moderngl
import numpy as np

from ..accel.triangles import Triangles, rotated_corners
from ..geometry.mesh import Mesh
from ..geometry.props import RINGS, SECTORS, Ground
from ..gpu.buffers import TextureBuffer
from ..gpu.memo import Last
from .probes import lift_off_facets

OFFSET = 0.05  # of a mesh's mean edge: how far rays that light a vertex start from it


@dataclass(frozen=True, eq=False)
class HitSurface:
    """One surface that rays can end at.

    Parameters
    ----------
    drawn, original : its mesh as it is drawn, and as it hides light; the first vertices of both are the same
    offsets : [V] how far from its vertices rays that light them start; None: OFFSET, and off the facets of `original`
    hiding : how many triangles of `original`, from the first on, hide light; None: all
    ground : whose vertices are the last of `drawn`
    """

    drawn: Mesh
    original: Mesh
    offsets: np.ndarray | None = None
    hiding: int | None = None
    ground: Ground | None = None


class HitVertices:
    """The triangles that hide light, and the drawn vertices of all surfaces, one after the other.

    `first_vertex` and `first_triangle` say where each surface begins, and how many there are in all.
    """

    def __init__(self, ctx: moderngl.Context):
        self._corners = TextureBuffer(ctx, 4, "r32i")
        self._vertices = TextureBuffer(ctx, 16)
        self._uploaded: Last[None] = Last()
        self._ground: dict[str, Any] = {}
        self.first_vertex, self.first_triangle = [0], [0]
        self.offset = 0.0  # metres, of rays from all vertices; a vertex may have more

    @property
    def vertex_count(self) -> int:
        """Of all surfaces."""
        return self.first_vertex[-1]

    def prepare(self, surfaces: Sequence[HitSurface], triangles: Triangles | None) -> None:
        """Upload the corners and vertices where they changed.

        Parameters
        ----------
        surfaces : in the order of their triangles in `triangles`; the offset of the first serves all, the others'
            come as lifts
        triangles : those the structure was built of
        """
        assert triangles is not None, "nothing was built"
        meshes = tuple((surface.drawn, surface.original) for surface in surfaces)
        self._uploaded.get(lambda: self._upload(surfaces, triangles), meshes, triangles)
        self._ground = {"ground_first": -1}
        for surface, end in zip(surfaces, self.first_vertex[1:], strict=True):
            if surface.ground is not None:
                self._ground = _ground_uniforms(surface.ground, end - 1 - RINGS * SECTORS)

    def _upload(self, surfaces: Sequence[HitSurface], triangles: Triangles) -> None:
        self.first_vertex, self.first_triangle = [0], [0]
        all_corners, all_rows = [], []
        for number, surface in enumerate(surfaces):
            corners = surface.original.triangles[: surface.hiding]
            rows = _rows(surface.drawn)
            if surface.drawn is not surface.original:
                rows[:, :2, 3] = lift_off_facets(surface.drawn, surface.original)
            if surface.offsets is None:
                offset = OFFSET * surface.original.mean_edge
                self.offset = self.offset if number else offset
                rows[:, :2, 3] += offset - self.offset
            else:
                self.offset = self.offset if number else 0.0
                rows[:, :2, 3] += surface.offsets[:, None] - self.offset
            all_corners.append(corners + self.first_vertex[-1])
            all_rows.append(rows)
            self.first_vertex.append(self.first_vertex[-1] + len(rows))
            self.first_triangle.append(self.first_triangle[-1] + len(corners))
        corners = np.concatenate(all_corners)
        self._corners.write(rotated_corners(corners, triangles.turn[: len(corners)]).astype("i4"))
        self._vertices.write(np.concatenate(all_rows))

    def inputs(self) -> dict[str, Any]:
        """The corners (three texels a triangle, in the order that hits are weighted in), the vertices (three texels each:
        position and normal, each with a lift, and tangent), and where the ground's are."""
        return {"corner_index": self._corners, "vertex_data": self._vertices, **self._ground}

    def inputs_of_hits(self) -> dict[str, Any]:
        """The same corners and vertices by the names of inputs/visibility/sheets.glsl, for passes that have others."""
        return {"hit_corners": self._corners, "hit_vertices": self._vertices}

    def release(self) -> None:
        """Free the GPU's memory."""
        self._corners.release()
        self._vertices.release()


def _ground_uniforms(ground: Ground, first: int) -> dict[str, Any]:
    """The uniforms of inputs/visibility/ground_cell.glsl; `first` is the number of the ground's first vertex."""
    return {
        "ground_first": first,
        "ground_middle": ground.center,
        "ground_scale": ground.scale,
        "ground_rings": RINGS,
        "ground_sectors": SECTORS,
    }


def _rows(mesh: Mesh) -> np.ndarray:
    """Positions, normals and tangents [V, 3, 4] float32, with no lift."""
    rows = np.zeros((len(mesh.positions), 3, 4), "f4")
    rows[:, 0, :3], rows[:, 1, :3], rows[:, 2] = mesh.positions, mesh.normals, mesh.tangents
    return rows
