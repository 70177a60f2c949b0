"""Meshes in other units, and at other places."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from .mesh import Mesh

METRES = {"m": 1.0, "dm": 0.1, "cm": 0.01, "mm": 0.001, "in": 0.0254}
# Cloth of 20 m is taken for one of 20 cm, one of 400 cm for one of 400 mm, and more than 10 m cannot be in millimetres:
# curtains of a hall stay in metres, a swatch has the size of a hand, and what is larger still is none of these.
CENTIMETRES, MILLIMETRES, NEITHER = 20.0, 400.0, 10_000.0


def guessed_unit(meshes: Sequence[Mesh]) -> str:
    """The unit of the lengths of cloth that a file does not say: metres, but where it would be too large."""
    boxes = np.array([mesh.bounds for mesh in meshes])
    extent = float((boxes[:, 1].max(0) - boxes[:, 0].min(0)).max())
    if not CENTIMETRES <= extent < NEITHER:
        return "m"
    return "cm" if extent < MILLIMETRES else "mm"


def placed(mesh: Mesh, scale: float = 1.0, turn_deg: float = 0.0, offset: Sequence[float] = (0.0, 0.0, 0.0)) -> Mesh:
    """A mesh scaled and turned about its origin (counter-clockwise seen from +Y), then moved by `offset`, metres."""
    if scale == 1.0 and turn_deg == 0.0 and not any(offset):
        return mesh
    c, s = np.cos(np.radians(turn_deg)), np.sin(np.radians(turn_deg))
    turn = np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])
    return replace(
        mesh,
        positions=scale * mesh.positions.astype(float) @ turn.T + np.asarray(offset, float),
        origin=tuple((scale * turn @ np.asarray(mesh.origin, float)).tolist()),
        scale=scale * mesh.scale,
        normals=mesh.normals @ turn.T,
        tangents=np.column_stack([mesh.tangents[:, :3] @ turn.T, mesh.tangents[:, 3]]),
    )
