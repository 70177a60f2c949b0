"""The built-in cloths that are kept as vertices of a simulation: a throw, a skirt and a length in folds."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from .mesh import Mesh, build_mesh
from .parts import joined
from .shapes import grid_triangles
from .spline import surface_mesh, unpacked
from .supports import WAIST, WAIST_AXES

SAMPLES = {"throw": (190, 190), "skirt": (84, 310), "folds": (120, 232)}  # rows and columns of the surface
# The skirt's band over the tops of its pleats: (m out from the waist, m above it), from its upper edge down.
BAND = (
    (-0.014, 0.022),
    (-0.004, 0.032),
    (0.012, 0.038),
    (0.024, 0.037),
    (0.030, 0.032),
    (0.0345, 0.022),
    (0.036, 0.004),
    (0.036, -0.014),
    (0.0345, -0.020),
)


def load_piece(name: str, folder: Path) -> Mesh:
    """The mesh of a piece whose vertices lie in `folder`."""
    return piece_mesh(name, *unpacked(folder / f"{name}.npz"))


def piece_mesh(name: str, positions: np.ndarray, size: tuple[float, float]) -> Mesh:
    """The surface over the vertices [R, C, 3] of a piece of a size (m), with what is sewn to it."""
    mesh = surface_mesh(name, positions, size, *SAMPLES[name])
    if name != "skirt":
        return mesh
    band = _band()
    part_of = np.repeat([0, 1], [len(mesh.triangles), len(band.triangles)])
    return replace(joined([mesh, band]), parts=(("Skirt",), ("Waistband",)), part_of=part_of)


def _band(columns: int = 220) -> Mesh:
    turns = np.linspace(-0.5, 0.5, columns)
    angle = 2.0 * np.pi * turns
    t = np.linspace(0, len(BAND) - 1, 4 * (len(BAND) - 1) + 1)
    out, up = (np.interp(t, np.arange(len(BAND)), np.array(BAND)[:, k]) for k in (0, 1))
    for _ in range(3):  # rounded
        out[1:-1], up[1:-1] = (0.25 * c[:-2] + 0.5 * c[1:-1] + 0.25 * c[2:] for c in (out, up))
    x = np.stack(
        [
            (WAIST_AXES[0] + out)[:, None] * np.sin(angle),
            np.repeat((WAIST + up)[:, None], columns, 1),
            (WAIST_AXES[1] + out)[:, None] * np.cos(angle),
        ],
        -1,
    )
    x[:, -1] = x[:, 0]
    around = 2.0 * np.pi * np.mean(WAIST_AXES)
    down = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(out), np.diff(up)))])
    u, v = np.meshgrid((turns + 0.5) * around, down[-1] - down)
    return build_mesh("band", x.reshape(-1, 3), grid_triangles(*x.shape[:2]), np.column_stack([u.ravel(), v.ravel()]))
