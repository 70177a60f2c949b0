"""A small flat piece of cloth to look at from near by, as the sheet of fabrics and the window show it."""

from __future__ import annotations

import numpy as np

from ..geometry.camera import Camera
from ..geometry.mesh import Mesh

FOV_DEG = 20.0
LEAN_DEG = 25.0  # from above the cloth: a little from the side shows how its yarns rise and dive


def patch(half: float) -> Mesh:
    """A square that faces +Z, of twice `half` metres, and lies as drafts are drawn: ends from left to right, picks from
    the top."""
    x, y = half * np.array([-1.0, 1.0, 1.0, -1.0]), half * np.array([-1.0, -1.0, 1.0, 1.0])
    return Mesh(
        "patch",
        np.column_stack([x, y, np.zeros(4)]),
        np.array([[0, 1, 2], [0, 2, 3]]),
        np.tile([0.0, 0.0, 1.0], (4, 1)),
        np.column_stack([half - y, half + x]),
        np.tile([0.0, -1.0, 0.0, 1.0], (4, 1)),
    )


def patch_camera(wide: float, aspect: float) -> Camera:
    """The eye that sees `wide` metres across the middle of a picture; `aspect` is the picture's width over its height."""
    distance = 0.5 * wide / aspect / np.tan(np.radians(FOV_DEG / 2))
    lean = np.radians(LEAN_DEG)
    return Camera((0.0, -distance * np.sin(lean), distance * np.cos(lean)), (0.0, 0.0, 0.0), fov_deg=FOV_DEG)
