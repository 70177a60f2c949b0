"""The thread counter, a weaver's glass: a square centimetre of the cloth under the pointer, with a scale, to count in."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..geometry.camera import Camera
from ..geometry.mesh import Mesh

SIDE = 0.01  # metres
TICKS = 10  # a side


class Glass(NamedTuple):
    """Where a square centimetre lies: its middle, and a metre of cloth along the warp and across it; [3] each."""

    middle: np.ndarray
    warp: np.ndarray
    weft: np.ndarray

    def place(self, u: float, v: float) -> np.ndarray:
        """A place on the cloth's tangent plane, (u, v) in sides from the middle."""
        return self.middle + SIDE * (u * self.warp + v * self.weft)

    def lines(self) -> list[tuple[np.ndarray, np.ndarray]]:
        """The square and its millimetres, as pairs of points [3]."""
        corners = [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)]
        out = [(corners[k], corners[(k + 1) % 4]) for k in range(4)]
        for k in range(1, TICKS):
            at, long = k / TICKS - 0.5, 0.10 if k == TICKS // 2 else 0.05
            out += [((at, -0.5), (at, -0.5 + long)), ((-0.5, at), (-0.5 + long, at))]
        return [(self.place(*a), self.place(*b)) for a, b in out]


def pixel_of(camera: Camera, size: tuple[int, int], point: np.ndarray) -> tuple[float, float] | None:
    """Where a point of the world is in a picture, (x, y) counted from its top left corner; None behind the eye."""
    if camera.ortho is not None:
        begin = camera.origin_from_pixel(size)
        along = camera.ray_from_pixel(size) @ (0.0, 0.0, 1.0)
        x, y, _ = np.linalg.solve(np.column_stack([begin[:, 0], begin[:, 1], along]), np.subtract(point, begin[:, 2]))
        return float(x), size[1] - float(y)
    ray = np.linalg.solve(camera.ray_from_pixel(size), np.subtract(point, camera.eye))
    return None if ray[2] <= 1e-9 else (float(ray[0] / ray[2]), size[1] - float(ray[1] / ray[2]))


def glass_at(mesh: Mesh, camera: Camera, size: tuple[int, int], x: float, y: float, scale: float) -> Glass | None:
    """The square centimetre under a place of the picture, (x, y) from its top left corner; None where there is no cloth.

    scale : metres a UV unit. The nearest triangle is found by Moller and Trumbore's test of all of them.
    """
    if mesh.uv is None:
        return None
    ray = camera.ray_from_pixel(size) @ (x, size[1] - y, 1.0)
    eye = np.asarray(camera.eye, float)
    if camera.ortho is not None:
        eye = camera.origin_from_pixel(size) @ (x, size[1] - y, 1.0)
    p = np.asarray(mesh.positions, float)[mesh.triangles]
    e_1, e_2, s = p[:, 1] - p[:, 0], p[:, 2] - p[:, 0], eye - p[:, 0]
    h = np.cross(ray, e_2)
    det = (e_1 * h).sum(-1)
    with np.errstate(divide="ignore", invalid="ignore"):
        q = np.cross(s, e_1)
        b_1, b_2, t = (s * h).sum(-1) / det, q @ ray / det, (e_2 * q).sum(-1) / det
    hit = (b_1 >= 0.0) & (b_2 >= 0.0) & (b_1 + b_2 <= 1.0) & (t > 0.0)
    if not hit.any():
        return None
    nearest = int(np.flatnonzero(hit)[np.argmin(t[hit])])
    uv = scale * np.asarray(mesh.uv, float)[mesh.triangles[nearest]]
    edges = np.stack([uv[1] - uv[0], uv[2] - uv[0]])
    if abs(np.linalg.det(edges)) < 1e-18:
        return None
    warp, weft = np.linalg.solve(edges, np.stack([e_1[nearest], e_2[nearest]]))
    return Glass(eye + t[nearest] * ray, warp, weft)
