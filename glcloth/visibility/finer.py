"""What hides the suns: the triangles of cloth cut finer along their curved surface, for the shadow of a flat triangle's edge is a
saw's tooth.   [own, docs/shadows.md]"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import moderngl

from ..accel.structure import Traced
from ..accel.triangles import Triangles
from ..geometry.mesh import Mesh
from ..gpu.programs import programs
from .hit_vertices import HitVertices
from .sheets import Sheets, sight

# Of a cloth's radius: the mean edge that is short enough; that which is after one cut; else there are two.
SHORT, ONCE = 1 / 300, 1 / 75
MOST_TRIANGLES = 400_000  # after the cuts
BULGE = 1.25  # times the largest coordinate: as far a cut may reach


@dataclass(frozen=True, eq=False)
class SunOccluders:
    """A structure that rays toward suns go through.

    Parameters
    ----------
    structure : over the finer triangles, and the ground
    levels : how often those of the cloths were cut into four; 0: it is the structure of all other rays
    cut : how many triangles were cut, from the first on
    own : how often those of the surface were that rays start from
    """

    structure: Traced
    levels: int = 0
    cut: int = 0
    own: int = 0

    def inputs(self) -> dict[str, Any]:
        """Of the structure, and of inputs/visibility/coarse.glsl."""
        numbers = {"finer_levels": self.levels, "finer_triangles": self.cut, "own_levels": self.own}
        return {**self.structure.inputs(), **numbers}

    def defines(self) -> dict[str, int]:
        """Of programs that ask which triangle a ray met."""
        return {"FINER": 1} if self.levels else {}

    def sight(self, sheets: Sheets | None) -> tuple[dict[str, int], dict[str, str], dict[str, Any]]:
        """As `sheets.sight`, toward suns."""
        defines, virtual, rays = sight(self.structure, sheets)
        return defines | (self.defines() if sheets is not None else {}), virtual, rays | self.inputs()


def cuts(cloths: Sequence[Mesh], triangles: int, others: int) -> int:
    """How often the triangles of cloths are cut: as often as the coarsest wants it, but not into more than MOST_TRIANGLES;
    `triangles` are theirs, `others` those that stay as they are."""
    levels = max((_cuts(mesh) for mesh in cloths), default=0)
    while levels and triangles * 4**levels + others > MOST_TRIANGLES:
        levels -= 1
    return levels


def _cuts(mesh: Mesh) -> int:
    edge = mesh.mean_edge / max(mesh.radius, 1e-30)
    return 0 if edge <= SHORT else 1 if edge <= ONCE else 2


class FinerTriangles:
    """Cuts the triangles of `HitVertices` on the GPU."""

    def __init__(self, ctx: moderngl.Context):
        self.ctx = ctx
        self._triangles: Triangles | None = None

    def cut(self, hit_vertices: HitVertices, coarse: Triangles, cut: int, levels: int) -> Triangles:
        """The first `cut` of the triangles each as 4^levels, the others behind them; `coarse`: as they are before."""
        count = cut * 4**levels + coarse.count - cut
        if self._triangles is None or self._triangles.count != count:
            self.release()
            self._triangles = Triangles(self.ctx, count, 1.0)
            self._triangles.attributes.write(bytes(16 * count))
        triangles = self._triangles
        triangles.padding = BULGE * coarse.padding
        numbers = {"finer_levels": levels, "finer_triangles": cut, "triangle_count": count}
        program = programs(self.ctx).compute("passes/visibility/finer.comp")
        program.run(count, hit_vertices.inputs(), numbers, Corners=triangles.corners)
        triangles.cut_needles(coarse.pieces is not None)
        return triangles

    def release(self) -> None:
        """Free the GPU's memory."""
        if self._triangles is not None:
            self._triangles.release()
        self._triangles = None
