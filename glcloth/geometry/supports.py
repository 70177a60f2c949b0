"""What the built-in cloths hang on and lie on: a dress form and a pedestal, as ellipsoids, boxes and balls; metres.

glcloth/simulation/pieces.py simulates with them; a scene shows them as the objects `form`, `pedestal` and `backdrop`.
"""

from __future__ import annotations

import numpy as np

from . import shapes
from .mesh import Mesh, assembled
from .raw import RawMesh

# Ellipsoids (centre, half axes) of the dress form, a woman's size 38: neck, shoulders, chest, waist, hips.
FORM = (
    ((0.0, 1.455, -0.004), (0.050, 0.130, 0.052)),
    ((0.0, 1.392, -0.012), (0.172, 0.050, 0.066)),
    ((0.0, 1.268, -0.004), (0.142, 0.170, 0.098)),
    ((0.0, 1.262, 0.034), (0.118, 0.074, 0.092)),
    ((0.0, 1.080, 0.000), (0.118, 0.200, 0.096)),
    ((0.0, 0.900, -0.006), (0.176, 0.200, 0.130)),
)
WAIST = 1.06  # its height
WAIST_AXES = (0.124, 0.101)  # half axes of the waist, over which the skirt's band lies
SHRUNK = 0.005  # how far the form that is seen lies within the one that cloth meets
PEDESTAL = (0.0, 0.45, 0.0), (0.22, 0.45, 0.22), 0.035  # a box: centre, outer half sides, rounding
HEAD = (0.0, 1.055, 0.0), 0.16  # a ball upon it
SWEEP = -2.6, 1.8, 3.8, 7.0  # the backdrop: where it leaves the floor (z), its radius, height, half width
PAPER = (0.38, 0.39, 0.41)
CLAY, WOOD, IRON, PLASTER = (0.46, 0.41, 0.35), (0.30, 0.19, 0.11), (0.06, 0.06, 0.06), (0.50, 0.48, 0.45)


def form() -> tuple[Mesh, np.ndarray]:
    """The dress form on its stand, and the reflectances [T, 3] of its triangles."""
    parts = [
        (_torso(), CLAY),
        (_turned([(0.0, 0.72), (0.016, 0.715), (0.016, 0.03)], 24), IRON),
        (_turned([(0.016, 0.035), (0.10, 0.03), (0.17, 0.012), (0.172, 0.0)], 48), WOOD),
        (
            _turned([(0.0, 1.605), (0.018, 1.595), (0.022, 1.58), (0.012, 1.565), (0.014, 1.556), (0.046, 1.548)], 32),
            WOOD,
        ),
    ]
    return together("form", parts)


def pedestal() -> tuple[Mesh, np.ndarray]:
    """The pedestal with its ball, and the reflectances [T, 3] of their triangles."""
    x, triangles, _, N = shapes.sphere(HEAD[1], 40, 80)
    parts = [(shapes.rounded_box(*PEDESTAL, 0.03), PLASTER), ((x + HEAD[0], triangles, N), PLASTER)]
    return together("pedestal", parts)


def backdrop() -> tuple[Mesh, np.ndarray]:
    """A sweep of grey paper behind the cloth, from the floor round into a wall, and the reflectances of its triangles."""
    begin, radius, height, half = SWEEP
    angle = np.linspace(0.0, 0.5 * np.pi, 20)
    z = np.concatenate([begin - radius * np.sin(angle), np.full(12, begin - radius)])
    y = np.concatenate([radius * (1.0 - np.cos(angle)), np.linspace(radius, height, 13)[1:]])
    x = np.linspace(-half, half, 57)
    points = np.stack([np.broadcast_to(x, (len(z), 57)), *(np.repeat(v[:, None], 57, 1) for v in (y, z))], -1)
    return together("backdrop", [((points.reshape(-1, 3), shapes.grid_triangles(len(z), 57)[:, ::-1], None), PAPER)])


def _torso(rows: int = 110, sectors: int = 96) -> tuple[np.ndarray, np.ndarray, None]:
    """The ellipsoids of the form as one smooth surface: at each height and in each direction the farthest of them."""
    heights = np.linspace(1.55, 0.712, rows)
    angle = np.linspace(0.0, 2.0 * np.pi, sectors, endpoint=False)
    way = np.column_stack([np.sin(angle), np.cos(angle)])  # x, z
    reach = np.zeros((len(FORM), rows, sectors))
    for n, (center, axes) in enumerate(FORM):
        e = (heights - center[1]) / axes[1]
        left = np.maximum(1.0 - e * e, 0.0)[:, None]
        # |(t way - c) / axes|^2 = left, for c on the plane x = 0
        a = (way[:, 0] / axes[0]) ** 2 + (way[:, 1] / axes[2]) ** 2
        b = way[:, 1] * center[2] / axes[2] ** 2
        root = b * b - a * ((center[2] / axes[2]) ** 2 - left)
        reach[n] = np.where((root > 0.0) & (left > 0.0), (b + np.sqrt(np.maximum(root, 0.0))) / a, 0.0)
    # Smooth where two of them meet, as cloth over wadding is.
    sharp = 120.0
    radius = np.log(np.exp(sharp * reach).sum(0) - len(FORM) + 1.0) / sharp - SHRUNK
    for _ in range(3):
        padded = np.vstack([radius[:1], radius, radius[-1:]])
        radius = 0.25 * padded[:-2] + 0.5 * padded[1:-1] + 0.25 * padded[2:]
    radius = np.maximum(radius, 0.002)
    radius[0] = radius[-1] = 0.001
    radius[1] *= 0.9
    x = np.stack([radius * way[:, 0], np.repeat(heights[:, None], sectors, 1), radius * way[:, 1]], -1)
    return x.reshape(-1, 3), _around(rows, sectors), None


def _around(rows: int, sectors: int) -> np.ndarray:
    """Triangles [T, 3] of rings one below the other, seen from outside."""
    s = np.arange(sectors)
    first = sectors * np.arange(rows - 1)[:, None]
    a, b, c, d = (first + k for k in (s, (s + 1) % sectors, s + sectors, (s + 1) % sectors + sectors))
    return np.stack([np.stack([a, c, d], -1), np.stack([a, d, b], -1)], 2).reshape(-1, 3)


def _turned(profile: list[tuple[float, float]], sectors: int) -> tuple[np.ndarray, np.ndarray, None]:
    """A surface of revolution from (radius, height) downwards, rounded between the points."""
    corners = np.array(profile)
    t = np.linspace(0, len(corners) - 1, 6 * (len(corners) - 1) + 1)
    radius, height = (np.interp(t, np.arange(len(corners)), corners[:, k]) for k in (0, 1))
    angle = np.linspace(0.0, 2.0 * np.pi, sectors, endpoint=False)
    x = np.stack(
        [np.outer(radius, np.sin(angle)), np.repeat(height[:, None], sectors, 1), np.outer(radius, np.cos(angle))], -1
    )
    return x.reshape(-1, 3), _around(len(t), sectors), None


def together(name: str, parts: list) -> tuple[Mesh, np.ndarray]:
    """Parts ((positions, triangles, normals or None), colour) as one mesh, and the reflectances [T, 3] of its triangles."""
    firsts = np.cumsum([0, *(len(part[0]) for part, _ in parts)])
    normals = [np.full_like(part[0], np.nan) if part[2] is None else part[2] for part, _ in parts]
    raw = RawMesh(
        np.concatenate([part[0] for part, _ in parts]),
        np.concatenate([part[1] + first for (part, _), first in zip(parts, firsts, strict=False)]),
        None,
        np.concatenate(normals),
    )
    mesh, kept = assembled(raw, name, name)
    return mesh, np.concatenate([np.tile(np.float32(color), (len(part[1]), 1)) for part, color in parts])[kept]
