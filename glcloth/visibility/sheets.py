"""Cloth that lets light through, as rays find it: what inputs/visibility/sheets.glsl reads.   [own, docs/shadows.md]"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import moderngl
import numpy as np

from ..accel.structure import Traced, tracing
from ..fabric import Transmission
from ..gpu.buffers import TextureBuffer
from ..twins.directions import cosine_directions
from ..twins.sheet import T_lambert, T_straight
from .hit_vertices import HitVertices

SHEER = 1e-3  # less light than that straight on is none
SIGHT_ANY, SIGHT_CLOSEST = "inputs/visibility/sight_any.glsl", "inputs/visibility/sight_closest.glsl"


class Sheets:
    """The transmission of each cloth of a frame, and where the triangles of each end."""

    def __init__(self, ctx: moderngl.Context, hit_vertices: HitVertices):
        self._data = TextureBuffer(ctx, 32)
        self._hit_vertices = hit_vertices
        self.transmissions: tuple[Transmission | None, ...] = ()

    def prepare(
        self, transmissions: Sequence[Transmission | None], always: bool = False, surfaces: Sequence[int] | None = None
    ) -> Sheets | None:
        """Take the cloths, whose surfaces are the first of the hit vertices; returns itself, or None where all are opaque,
        but `always` itself. `surfaces`: the number of each one's surface, where some share it."""
        self.transmissions = tuple(transmissions)
        if not (any(self.transmissions) or always):
            return None
        rows = np.zeros((len(transmissions), 2, 4), "f4")
        for row, t in zip(rows, transmissions, strict=True):
            if t is not None:
                row[0], row[1, :3] = (t.rho, t.k_a, t.k_t, t.diffuse), t.tau
        ends = np.asarray(self._hit_vertices.first_triangle[1:])
        rows[:, 1, 3] = ends[np.arange(len(rows)) if surfaces is None else np.asarray(surfaces)]
        self._data.write(rows)
        return self

    def inputs(self) -> dict[str, Any]:
        """By their names in GLSL."""
        names = {"sheet_data": self._data, "sheet_count": len(self.transmissions)}
        return names | self._hit_vertices.inputs_of_hits()

    def release(self) -> None:
        """Free the GPU's memory."""
        self._data.release()


def sight(
    structure: Traced, sheets: Sheets | None, opaque: str = SIGHT_ANY
) -> tuple[dict[str, int], dict[str, str], dict[str, Any]]:
    """Defines, virtual includes and inputs of a pass that asks by "sight.glsl" what is seen along rays; `opaque`: the file
    where no cloth lets light through."""
    virtual = {"sight.glsl": opaque, **tracing(structure)}
    if sheets is None:
        return {}, virtual, structure.inputs()
    virtual["sight.glsl"] = "inputs/visibility/sheets.glsl"
    return {"SHEER": 1}, virtual, structure.inputs() | sheets.inputs()


def sees_through(t: Transmission | None) -> bool:
    """Whether what is behind a cloth is seen through it."""
    if t is None:
        return False
    normal = np.array([0.0, 0.0, 1.0])
    return bool(T_straight(normal, t.k_a, t.k_t, np.array(t.tau), t.rho, t.diffuse).max() > SHEER)


class Passed(NamedTuple):
    """The shares [3] of even light that come through a cloth, in the mean over all views by their cosine."""

    evenly: np.ndarray
    straight: np.ndarray

    @classmethod
    def of(cls, t: Transmission | None) -> Passed:
        """Of a fabric's transmission; None: nothing comes through."""
        if t is None:
            return cls(np.zeros(3), np.zeros(3))
        views, tau = cosine_directions(256), np.array(t.tau)
        evenly = T_lambert(views, t.k_t, tau, t.rho, t.diffuse).mean(0)
        return cls(evenly, T_straight(views, t.k_a, t.k_t, tau, t.rho, t.diffuse).mean(0))
