"""A triangle mesh with a yarn frame at every vertex, and the frames of given arrays.

The frame is (x, y, N): x = yarn 1 = the direction of growing u in the tangent plane, y = yarn 2 = w cross(N, x) with
w = -1 where the UVs are mirrored. A vertex where mirrored and unmirrored triangles meet is split in two.

Without UVs yarn 1 is a world axis projected into the tangent plane: of +X, +Z, +Y the first one that the fewest
normals (by area) lie near. The field is continuous except where a normal is parallel to that axis; there the next
axis serves.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..errors import InputError
from .obj import split_vertices

LARGEST = 1e9  # beyond it float32 leaves no digits for a cloth


@dataclass(frozen=True, eq=False)
class Mesh:
    """A triangle mesh whose arrays are read-only; lengths in metres, +Y up, counter-clockwise seen from the side of N.

    positions [V, 3] float32; triangles [T, 3] int32; normals [V, 3] float32 unit; uv [V, 2] float32 or None;
    tangents [V, 4] float32: xyz = yarn 1, unit and orthogonal to the normal, w = +-1: yarn 2 = w cross(N, xyz).
    """

    name: str
    positions: np.ndarray
    triangles: np.ndarray
    normals: np.ndarray
    uv: np.ndarray | None
    tangents: np.ndarray

    def __post_init__(self):
        vertex_count = len(self.positions)
        shapes_expected = {
            "positions": (vertex_count, 3),
            "triangles": (len(self.triangles), 3),
            "normals": (vertex_count, 3),
            "uv": (vertex_count, 2),
            "tangents": (vertex_count, 4),
        }
        for field, shape in shapes_expected.items():
            value = getattr(self, field)
            if value is None and field == "uv":
                continue
            array = np.ascontiguousarray(value, np.int32 if field == "triangles" else np.float32)
            if array.shape != shape:
                raise ValueError(f"mesh {self.name}: {field} has shape {array.shape}, expected {shape}")
            array = array.copy() if array is value and array.flags.writeable else array
            array.flags.writeable = False
            object.__setattr__(self, field, array)

    def _used(self) -> np.ndarray:
        used = np.zeros(len(self.positions), bool)
        used[self.triangles] = True
        return self.positions[used].astype(float)

    @property
    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the corners (low [3], high [3]) of the axis-aligned box about all triangles, float64."""
        used = self._used()
        return used.min(axis=0), used.max(axis=0)

    @property
    def center(self) -> np.ndarray:
        """Return the centre [3] of the bounding box, float64."""
        low, high = self.bounds
        return (low + high) / 2

    @property
    def mean_edge(self) -> float:
        """Return the mean length of the triangles' sides."""
        corners = self.positions[self.triangles].astype(float)
        return float(np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).mean())

    def edges(self) -> np.ndarray:
        """Return each edge once, [E, 2], the lower vertex first."""
        corners = self.triangles
        return np.unique(np.sort(np.concatenate([corners[:, pair] for pair in ([0, 1], [1, 2], [2, 0])]), 1), axis=0)

    @property
    def radius(self) -> float:
        """Return the radius of the sphere about `center` that holds every triangle."""
        used = self._used()
        return float(np.linalg.norm(used - self.center, axis=1).max())


def build_mesh(
    name: str,
    positions: np.ndarray,
    triangles: np.ndarray,
    uv: np.ndarray | None = None,
    normals: np.ndarray | None = None,
    where: str | None = None,
) -> Mesh:
    """Return a Mesh with unit normals and yarn frames from arrays; rows of uv and normals may be NaN for "none".

    positions [V, 3], triangles [T, 3] int, uv [V, 2], normals [V, 3]. Missing normals are smooth over coincident
    vertices. Raises InputError (naming `where`) for no faces, indices out of range, and numbers that are not finite.
    """
    positions, triangles = _checked(positions, triangles, where or f"mesh {name}")
    N = _vertex_normals(positions, triangles, normals)
    if uv is not None:
        uv = np.asarray(uv, np.float64)
        corner_tangent, corner_sign = _corner_tangents(positions, triangles, uv, N)
        if corner_sign.any():
            triangles, sources, sign = _split_at_mirrors(triangles, corner_sign, len(positions))
            uv = np.nan_to_num(uv[sources], nan=0.0, posinf=0.0, neginf=0.0)
            positions, N = positions[sources], N[sources]
            return Mesh(name, positions, triangles, N, uv, _tangents(positions, triangles, N, uv, corner_tangent, sign))
    tangents = np.column_stack([_fallback_tangents(N, _axis_order(positions, triangles, N)), np.ones(len(N))])
    return Mesh(name, positions, triangles, N, None, tangents)


def _checked(positions: np.ndarray, triangles: np.ndarray, where: str) -> tuple[np.ndarray, np.ndarray]:
    """Return positions rounded to float32 and triangles, or raise InputError."""
    positions = np.asarray(positions, np.float64)
    triangles = np.asarray(triangles, np.int64)
    if len(triangles) == 0:
        raise InputError(f"{where}: holds no triangles; export it with its faces")
    if triangles.min() < 0 or triangles.max() >= len(positions):
        worst = triangles.min() if triangles.min() < 0 else triangles.max()
        raise InputError(
            f"{where}: a face names vertex {worst}, out of range, {len(positions)} defined; export it again"
        )
    with np.errstate(over="ignore", invalid="ignore"):
        rounded = positions.astype(np.float32)
    bad = np.flatnonzero(~np.isfinite(rounded).all(axis=1))
    if len(bad):
        raise InputError(
            f"{where}: vertex {bad[0]} is ({', '.join(f'{c:g}' for c in positions[bad[0]])}), expected finite numbers; "
            "mend the mesh"
        )
    positions = rounded.astype(np.float64)
    largest = float(np.abs(positions).max())
    if largest > LARGEST:
        raise InputError(f"{where}: coordinates up to {largest:g}, expected at most {LARGEST:g}; rescale the mesh")
    corners = positions[triangles]
    areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    if not areas.any():
        raise InputError(f"{where}: every triangle has no area, there is nothing to see; mend the mesh")
    return positions, triangles


def _split_at_mirrors(triangles: np.ndarray, corner_sign: np.ndarray, count: int) -> tuple[np.ndarray, ...]:
    """Split vertices whose corners differ in handedness; returns (triangles, the old vertex of each, its handedness)."""
    # Corners without a sign (degenerate UVs) take the sign of another corner of their vertex.
    flat = triangles.ravel()
    sign = corner_sign.ravel().copy()
    known = np.zeros(count)
    known[flat[::-1][sign[::-1] != 0]] = sign[::-1][sign[::-1] != 0]
    sign = np.where(sign == 0, np.where(known[flat] == 0, 1, known[flat]), sign).astype(np.int64)
    corner, sources, first = split_vertices(flat, sign[:, None], count)
    return corner.reshape(-1, 3), sources, np.where(first < 0, 1, sign[first])


def _tangents(positions, triangles, N, uv, corner_tangent, sign) -> np.ndarray:
    """Return tangents [V, 4] from those of the corners, alike at vertices with the same place, UVs, normal and sign."""
    keys = np.column_stack([positions, uv, N, sign])
    summed = _sum_at_coincident(keys, triangles.ravel(), corner_tangent.reshape(-1, 3))
    x = summed - N * np.sum(N * summed, axis=1, keepdims=True)
    length = np.linalg.norm(x, axis=1, keepdims=True)
    lost = length[:, 0] < 1e-6
    x = x / np.where(lost[:, None], 1.0, length)
    if lost.any():
        x[lost] = _fallback_tangents(N[lost], _axis_order(positions, triangles, N))
    return np.column_stack([x, sign])


def _unit(v: np.ndarray) -> np.ndarray:
    """Return v / |v| along the last axis; zero stays zero."""
    length = np.linalg.norm(v, axis=-1, keepdims=True)
    return v / np.where(length == 0, 1.0, length)


def _corner_angles(positions: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Return the [T, 3] interior angles in radians, 0 throughout a triangle without area."""
    p = positions[triangles]
    e = _unit(np.roll(p, -1, axis=1) - p)
    angles = np.arccos(np.clip(-np.sum(e * np.roll(e, 1, axis=1), axis=2), -1.0, 1.0))
    angles[np.linalg.norm(_area_vectors(positions, triangles), axis=1) == 0] = 0.0
    return angles


def _area_vectors(positions: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Return [T, 3]: the normals scaled by the areas, exactly zero for triangles that are lines or points."""
    a, b, c = (positions[triangles[:, i]] for i in range(3))
    S = np.cross(b - a, c - a) / 2
    longest = np.max([np.sum((b - a) ** 2, 1), np.sum((c - b) ** 2, 1), np.sum((a - c) ** 2, 1)], axis=0)
    # Positions are float32, so heights below 1e-6 of the longest side are rounding, not shape.
    S[np.linalg.norm(S, axis=1) <= 1e-6 * longest] = 0.0
    return S


def _sum_at_coincident(keys: np.ndarray, corner: np.ndarray, value: np.ndarray) -> np.ndarray:
    """Sum `value` [C, n] of the corners at each vertex, vertices with equal `keys` [V, k] counting as one; [V, n]."""
    # + 0.0 makes -0 and 0 the same key.
    _, group = np.unique(keys + 0.0, axis=0, return_inverse=True)
    group = group.reshape(-1)
    total = np.zeros((group.max() + 1, value.shape[1]))
    np.add.at(total, group[corner], value)
    return total[group]


def _vertex_normals(positions: np.ndarray, triangles: np.ndarray, given: np.ndarray | None) -> np.ndarray:
    """Return [V, 3] unit normals: the given ones where usable, else face normals weighted by corner angle.

    The angle weights make the sum independent of how the surface is cut into triangles (Thuermer and Wuethrich 1998).
    """
    face_normal = _unit(_area_vectors(positions, triangles))
    weighted = (_corner_angles(positions, triangles)[..., None] * face_normal[:, None, :]).reshape(-1, 3)
    corner = triangles.ravel()
    N = _sum_at_coincident(positions, corner, weighted)
    # Two sheets back to back cancel when they are summed as one: then each vertex speaks for itself.
    weight = _sum_at_coincident(positions, corner, np.linalg.norm(weighted, axis=1, keepdims=True))
    cancelled = np.linalg.norm(N, axis=1) <= 1e-3 * weight[:, 0]
    if cancelled.any():
        alone = np.zeros_like(positions)
        np.add.at(alone, corner, weighted)
        N[cancelled] = alone[cancelled]
    N = _unit(N)
    lost = np.linalg.norm(N, axis=1) < 0.5
    if lost.any():
        # Any face's normal is better than none; a vertex of no true triangle gets +Y, which nothing will show.
        any_face = np.tile([0.0, 1.0, 0.0], (len(positions), 1))
        solid = np.linalg.norm(face_normal, axis=1) > 0.5
        any_face[triangles[solid].ravel()] = np.repeat(face_normal[solid], 3, axis=0)
        N[lost] = any_face[lost]
    if given is not None:
        given = np.asarray(given, np.float64)
        with np.errstate(invalid="ignore"):
            length = np.linalg.norm(given, axis=1)
            usable = np.isfinite(length) & (length > 1e-6)
        N[usable] = given[usable] / length[usable, None]
    return N


def _corner_tangents(
    positions: np.ndarray, triangles: np.ndarray, uv: np.ndarray, N: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return per corner: unit dP/du times the corner angle [T, 3, 3], and the handedness [T, 3] (0 = unusable UVs).

    dP/du = (e1 dv2 - e2 dv1) / (du1 dv2 - du2 dv1); the sign of that determinant says whether the UVs are mirrored,
    counted against N, which a file may point away from the winding's side.
    """
    p, t = positions[triangles], uv[triangles]
    e_1, e_2 = p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]
    d_1, d_2 = t[:, 1] - t[:, 0], t[:, 2] - t[:, 0]
    S = _area_vectors(positions, triangles)
    with np.errstate(invalid="ignore", over="ignore"):
        determinant = d_1[:, 0] * d_2[:, 1] - d_2[:, 0] * d_1[:, 1]
        # Relative: UVs may be in metres, texels or fractions; 1e-6 is what float32 UVs leave of a line.
        scale = np.max([np.sum(d_1**2, 1), np.sum(d_2**2, 1), np.sum((d_2 - d_1) ** 2, 1)], axis=0)
        usable = np.isfinite(t).all(axis=(1, 2)) & (np.abs(determinant) > 1e-6 * scale) & (S != 0).any(axis=1)
        x = _unit((e_1 * d_2[:, 1:] - e_2 * d_1[:, 1:]) * np.sign(determinant)[:, None])
    angle = _corner_angles(positions, triangles)
    side = np.where(np.sum(N[triangles] * S[:, None, :], axis=2) < 0, -1.0, 1.0)
    x = np.where(usable[:, None], x, 0.0)
    return x[:, None, :] * angle[..., None], np.where(usable, np.sign(np.nan_to_num(determinant)), 0.0)[:, None] * side


def _axis_order(positions: np.ndarray, triangles: np.ndarray, N: np.ndarray) -> Sequence[int]:
    """Return the axes X, Z, Y (as 0, 2, 1), the one with the least area near it first."""
    area = np.linalg.norm(_area_vectors(positions, triangles), axis=1)
    facing = np.abs(N[triangles].mean(axis=1)) > np.cos(np.radians(25.0))
    near = (area[:, None] * facing).sum(axis=0) / max(area.sum(), 1e-300)
    # Rounded, so that symmetric meshes keep the stated order.
    return sorted((0, 2, 1), key=lambda axis: round(float(near[axis]), 2))


def _fallback_tangents(N: np.ndarray, axes: Sequence[int]) -> np.ndarray:
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
