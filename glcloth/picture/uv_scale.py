"""How long a UV unit of a mesh is."""

from __future__ import annotations

import numpy as np

from ..geometry.mesh import Mesh
from ..progress import warn

METRES = (0.75, 1.33)  # metres a UV unit that are taken for one: such UVs are metres, on a cloth that is stretched


def guessed_scale(mesh: Mesh) -> float:
    """Metres a UV unit, from areas; 1 where UVs are metres already, else with a warning."""
    assert mesh.uv is not None
    p, t = np.asarray(mesh.positions, float)[mesh.triangles], np.asarray(mesh.uv, float)[mesh.triangles]
    area = np.linalg.norm(np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]), axis=1).sum()
    a, b = t[:, 1] - t[:, 0], t[:, 2] - t[:, 0]
    in_uv = np.abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum()
    scale = float(np.sqrt(area / in_uv)) if in_uv > 0.0 and area > 0.0 else 1.0
    if METRES[0] <= scale <= METRES[1]:
        return 1.0
    warn(f"{mesh.name}: its UVs are no metres; a UV unit is taken for {scale:.3g} m, uv_scale says another")
    return scale
