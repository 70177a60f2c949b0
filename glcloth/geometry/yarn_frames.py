"""The yarn frames at the vertices of triangles: normals, and tangents along yarn 1.

The frame is (x, y, N): x = yarn 1 = the direction of growing u in the tangent plane, y = yarn 2 = w cross(N, x) with
w = -1 where the UVs are mirrored. A vertex where mirrored and unmirrored triangles meet is split in two.

Without UVs yarn 1 is a world axis projected into the tangent plane: of +X, +Z, +Y the first one that the fewest
normals (by area) lie near. The field is continuous except where a normal is parallel to that axis; there the next
axis serves.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .coincident import distinct, split_vertices
from .faces import Faces, chunks, dot, gathered, sums, unit


def split_at_mirrors(triangles: np.ndarray, corner_sign: np.ndarray, count: int) -> tuple[np.ndarray, ...]:
    """Split vertices whose corners differ in handedness; returns (triangles, the old vertex of each, its handedness)."""
    # Corners without a sign (degenerate UVs) take the sign of another corner of their vertex.
    flat = triangles.ravel()
    sign = corner_sign.ravel().copy()
    known = np.zeros(count)
    known[flat[::-1][sign[::-1] != 0]] = sign[::-1][sign[::-1] != 0]
    if ((sign == 0) | (known[flat] == sign)).all():  # nothing to split
        return triangles, np.arange(count), np.where(known == 0, 1, known).astype(np.int64)
    sign = np.where(sign == 0, np.where(known[flat] == 0, 1, known[flat]), sign).astype(np.int64)
    corner, sources, first = split_vertices(flat, sign[:, None], count)
    return corner.reshape(-1, 3), sources, np.where(first < 0, 1, sign[first])


def vertex_tangents(place, faces: Faces, N, uv, weighted, sign) -> np.ndarray:
    """Return tangents [V, 4] from those of corners [3, 3, T], alike at vertices with the same place, UVs, normal, sign."""
    _, group = distinct(np.column_stack([place, uv, N, sign]))
    summed = sums(group, faces.triangles, weighted)
    x = summed - N * np.sum(N * summed, axis=1, keepdims=True)
    length = np.linalg.norm(x, axis=1, keepdims=True)
    lost = length[:, 0] < 1e-6
    x = x / np.where(lost[:, None], 1.0, length)
    if lost.any():
        x[lost] = projected_axes(N[lost], axis_order(faces, N))
    return np.column_stack([x, sign])


def _unit(v: np.ndarray) -> np.ndarray:
    """Return v / |v| along the last axis; zero stays zero."""
    length = np.linalg.norm(v, axis=-1, keepdims=True)
    return v / np.where(length == 0, 1.0, length)


def vertex_normals(
    count: int, place: np.ndarray, faces: Faces, angles: np.ndarray, given: np.ndarray | None
) -> np.ndarray:
    """Return [V, 3] unit normals: the given ones where usable, else face normals weighted by corner angle.

    The angle weights make the sum independent of how the surface is cut into triangles (Thuermer and Wuethrich 1998).
    """
    triangles, face_normal = faces.triangles, unit(faces.area)
    weighted = angles[:, None] * face_normal
    N = sums(place, triangles, weighted)
    # Two sheets back to back cancel when they are summed as one: then each vertex speaks for itself.
    weight = sums(place, triangles, angles[:, None])
    cancelled = np.linalg.norm(N, axis=1) <= 1e-3 * weight[:, 0]
    if cancelled.any():
        alone = sums(np.arange(count), triangles, weighted)
        N[cancelled] = alone[cancelled]
    N = _unit(N)
    lost = np.linalg.norm(N, axis=1) < 0.5
    if lost.any():
        # Any face's normal is better than none; a vertex of no true triangle gets +Y, which nothing will show.
        any_face = np.tile([0.0, 1.0, 0.0], (count, 1))
        any_face[triangles.ravel()] = np.repeat(face_normal.T, 3, axis=0)
        N[lost] = any_face[lost]
    if given is not None:
        with np.errstate(invalid="ignore"):
            length = np.linalg.norm(given, axis=1)
            usable = np.isfinite(length) & (length > 1e-6)
        N[usable] = given[usable] / length[usable, None]
    return N


def face_tangents(faces: Faces, uv: np.ndarray, N: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return of each face unit dP/du [3, T], 0 where UVs are unusable, and of its corners the handedness [3, T], likewise.

    dP/du = (e1 dv2 - e2 dv1) / (du1 dv2 - du2 dv1); the sign of that determinant says whether the UVs are mirrored,
    counted against N, which a file may point away from the winding's side.
    """
    count = len(faces.triangles)
    tangent, sign = np.empty((3, count)), np.empty((3, count))
    for part in chunks(count):
        tangent[:, part], sign[:, part] = _tangents_of_some(faces, part, uv, N)
    return tangent, sign


def _tangents_of_some(faces: Faces, part: slice, uv: np.ndarray, N: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    triangles, S = faces.triangles[part], faces.area[:, part]
    t = gathered(uv, triangles)
    e_1, e_2 = faces.edges[0, :, part], -faces.edges[2, :, part]
    with np.errstate(invalid="ignore", over="ignore"):
        d_1, d_2 = t[1] - t[0], t[2] - t[0]
        determinant = d_1[0] * d_2[1] - d_2[0] * d_1[1]
        # Relative: UVs may be in metres, texels or fractions; 1e-6 is what float32 UVs leave of a line.
        scale = np.maximum(np.maximum(_squared(d_1), _squared(d_2)), _squared(d_2 - d_1))
        usable = np.isfinite(t).all(axis=(0, 1)) & (np.abs(determinant) > 1e-6 * scale) & (S != 0).any(axis=0)
        x = unit((e_1 * d_2[1] - e_2 * d_1[1]) * np.sign(determinant))
    side = np.where(dot(gathered(N, triangles), S[None]) < 0, -1.0, 1.0)
    return np.where(usable, x, 0.0), np.where(usable, np.sign(np.nan_to_num(determinant)), 0.0) * side


def _squared(d: np.ndarray) -> np.ndarray:
    return d[0] ** 2 + d[1] ** 2


def axis_order(faces: Faces, N: np.ndarray) -> Sequence[int]:
    """Return the axes X, Z, Y (as 0, 2, 1), the one with the least area near it first."""
    area = np.sqrt(dot(faces.area, faces.area))
    facing = np.abs(N[faces.triangles].mean(axis=1)) > np.cos(np.radians(25.0))
    near = (area[:, None] * facing).sum(axis=0) / max(area.sum(), 1e-300)
    # Rounded, so that symmetric meshes keep the stated order.
    return sorted((0, 2, 1), key=lambda axis: round(float(near[axis]), 2))


def projected_axes(N: np.ndarray, axes: Sequence[int]) -> np.ndarray:
    """Return [V, 3] unit tangents: the first of `axes` not (nearly) parallel to N, projected."""
    x = np.zeros_like(N)
    todo = np.ones(len(N), bool)
    for axis in axes:
        e = np.zeros(3)
        e[axis] = 1.0
        t = e - N * N[:, [axis]]
        length = np.linalg.norm(t, axis=1)
        take = todo & (length > 1e-3)
        x[take] = t[take] / length[take, None]
        todo &= ~take
    return x
