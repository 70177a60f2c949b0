"""Where rays from cloth and from what stands about it can end: all corners and vertices in one numbering, on the GPU."""

from __future__ import annotations

import numpy as np

from ..accel.triangles import Triangles, rotated_corners
from ..geometry.mesh import Mesh
from ..gpu import shader
from ..gpu.buffers import TextureBuffer
from .probes import lift_off_facets
from .solids import Around, ground_uniforms

OFFSET = 0.05  # of the cloth's mean edge: how far rays that light a vertex start from it


class Places:
    """The triangles that hide light, and the vertices of what is drawn: first the cloth's, then those about it."""

    def __init__(self, ctx):
        self._corners = TextureBuffer(ctx, 4, "r32i")
        self._vertices = TextureBuffer(ctx, 16)
        self._of: tuple | None = None
        self.cloth_vertices = self.cloth_triangles = self.vertex_count = 0
        self.offset = 0.0  # metres, of rays from all vertices; a vertex may have more

    def prepare(self, drawn: Mesh, original: Mesh, around: Around | None, triangles: Triangles) -> None:
        """Upload what changed.

        Parameters
        ----------
        drawn, original : the cloth's mesh as it is drawn, and as it hides light; the first vertices of both are the same
        around : what stands about it
        triangles : what the structure was built of: the cloth's, then those of the objects
        """
        of = drawn, around and around.mesh, triangles
        self._around = around
        if self._of == of:
            return
        corners, rows = original.triangles, _rows(drawn)
        self.offset = OFFSET * _mean_edge(original)
        if drawn is not original:
            rows[:, :2, 3] = lift_off_facets(drawn, original)
        if around is not None:
            solid = around.mesh.triangles[: around.solid]
            corners = np.concatenate([corners, solid + len(rows)])
            more = _rows(around.mesh)
            more[:, :2, 3] = around.offsets[:, None] - self.offset
            rows = np.concatenate([rows, more])
        self._corners.write(rotated_corners(corners, triangles.turn[: len(corners)]).astype("i4"))
        self._vertices.write(rows)
        self.cloth_triangles, self.cloth_vertices = len(original.triangles), len(drawn.positions)
        self.vertex_count = len(rows)
        self._of = of

    def bind(self, program, corners_unit: int, vertices_unit: int) -> None:
        """Bind the corners (three texels a triangle, in the order that hits are weighted in) and the vertices (three texels
        each: position and normal, each with a lift, and tangent), and say where the ground's are."""
        self._corners.bind(corners_unit)
        self._vertices.bind(vertices_unit)
        if self._around is not None:
            first = self.cloth_vertices + self._around.solid_vertices
            shader.set_uniforms(program, **ground_uniforms(self._around.objects, first))


def _rows(mesh: Mesh) -> np.ndarray:
    """Positions, normals and tangents [V, 3, 4] float32, with no lift."""
    rows = np.zeros((len(mesh.positions), 3, 4), "f4")
    rows[:, 0, :3], rows[:, 1, :3], rows[:, 2] = mesh.positions, mesh.normals, mesh.tangents
    return rows


def _mean_edge(mesh: Mesh) -> float:
    corners = mesh.positions[mesh.triangles].astype(float)
    return float(np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).mean())
