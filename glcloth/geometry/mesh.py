"""A triangle mesh with a yarn frame at every vertex, and the frames of given arrays.

The frame is (x, y, N): x = yarn 1 = the direction of growing u in the tangent plane, y = yarn 2 = w cross(N, x) with
w = -1 where the UVs are mirrored. A vertex where mirrored and unmirrored triangles meet is split in two.

Without UVs yarn 1 is a world axis projected into the tangent plane: of +X, +Z, +Y the first one that the fewest
normals (by area) lie near. The field is continuous except where a normal is parallel to that axis; there the next
axis serves.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..errors import InputError
from .coincident import distinct, split_vertices
from .faces import Faces, chunks, dot, gathered, sums, unit
from .raw import Names, RawMesh, check_counts
from .winding import dropped, turned

LARGEST = 1e7  # m; beyond it float64 leaves no digits for a thread
FAR = 256.0  # radii from the origin, beyond which float32 leaves too few digits for the shape


@dataclass(frozen=True, eq=False)
class Mesh:
    """A triangle mesh whose arrays are read-only; lengths in metres, +Y up, counter-clockwise seen from the side of N.

    positions [V, 3] float32; triangles [T, 3] int32; normals [V, 3] float32 unit; uv [V, 2] float32 or None;
    tangents [V, 4] float32: xyz = yarn 1, unit and orthogonal to the normal, w = +-1: yarn 2 = w cross(N, xyz).
    parts: the names of each part that the file tells apart, (material, group, object) as far as it has them;
    part_of [T] int32: each triangle's part. origin: where (0, 0, 0) is in the file's space, m, other than there only for
    a mesh that lies far from it. scale: metres in a unit of the file.
    """

    name: str
    positions: np.ndarray
    triangles: np.ndarray
    normals: np.ndarray
    uv: np.ndarray | None
    tangents: np.ndarray
    parts: tuple[Names, ...] = ()
    part_of: np.ndarray | None = None
    origin: tuple[float, float, float] = (0.0, 0.0, 0.0)
    scale: float = 1.0

    @classmethod
    def from_arrays(
        cls, positions: np.ndarray, triangles: np.ndarray, uv: np.ndarray | None = None, *, name: str = "mesh"
    ) -> Mesh:
        """Return a mesh of arrays, with smooth normals and yarn frames, as `load_mesh` gives it for a file.

        Parameters
        ----------
        positions : [V, 3] metres, +Y up
        triangles : [T, 3] whole numbers, three vertices each; those without area, and all but the first of equal ones,
            are left out
        uv : [V, 2] texture coordinates: yarn 1 runs along growing u; None: along a projected world axis
        name : what messages call it

        Vertices keep their order; where mirrored and unmirrored UVs meet they are split, and the twins appended. Arrays
        are copied. Raises InputError for other shapes and kinds, indices out of range, numbers that are not finite, and
        where nothing has an area.
        """
        return build_mesh(name, *_as_arrays(name, positions, triangles, uv))

    def __post_init__(self):
        vertex_count = len(self.positions)
        shapes_expected = {
            "positions": (vertex_count, 3),
            "triangles": (len(self.triangles), 3),
            "normals": (vertex_count, 3),
            "uv": (vertex_count, 2),
            "tangents": (vertex_count, 4),
            "part_of": (len(self.triangles),),
        }
        for field, shape in shapes_expected.items():
            value = getattr(self, field)
            if value is None and field in ("uv", "part_of"):
                continue
            array = np.ascontiguousarray(value, np.int32 if field in ("triangles", "part_of") else np.float32)
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

    def moved(self, positions: np.ndarray) -> Mesh:
        """The same cloth with its vertices elsewhere: normals and yarn frames follow.

        positions : [V, 3] metres, as many and in the order of this mesh's

        Raises InputError for another number of vertices, and for numbers that are not finite.
        """
        positions = np.asarray(positions)
        if positions.shape != self.positions.shape:
            shape = "x".join(map(str, positions.shape))
            raise InputError(
                f"mesh {self.name}: {shape} positions, expected {len(self.positions)}x3, those of its vertices"
            )
        positions = positions.astype(np.float32).astype(np.float64)
        if not (np.abs(positions) <= LARGEST).all():
            raise InputError(f"mesh {self.name}: positions, expected finite numbers up to {LARGEST:g}")
        _, place = distinct(self.positions.astype(np.float64))  # what was sewn stays so, what meets is not
        new = Faces.of(positions, self.triangles)
        angles = new.angles()
        N = _vertex_normals(len(positions), place, new, angles, None)
        sign = self.tangents[:, 3].astype(float)
        if self.uv is None:
            tangents = np.column_stack([_fallback_tangents(N, _axis_order(new, N)), sign])
        else:
            uv = self.uv.astype(float)
            weighted = _face_tangents(new, uv, N)[0] * angles[:, None]
            tangents = _tangents(place, new, N, uv, weighted, sign)
        return replace(self, positions=positions, normals=N, tangents=tangents)

    def edges(self) -> np.ndarray:
        """Return each edge once, [E, 2], the lower vertex first."""
        corners = self.triangles
        return np.unique(np.sort(np.concatenate([corners[:, pair] for pair in ([0, 1], [1, 2], [2, 0])]), 1), axis=0)

    @property
    def radius(self) -> float:
        """Return the radius of the sphere about `center` that holds every triangle."""
        used = self._used()
        return float(np.linalg.norm(used - self.center, axis=1).max())


def relative_to(mesh: Mesh, origin: tuple[float, float, float]) -> Mesh:
    """The same mesh where (0, 0, 0) is another point of its file's space."""
    offset = np.subtract(mesh.origin, origin)
    if not offset.any():
        return mesh
    return replace(mesh, positions=(mesh.positions + offset).astype(np.float32), origin=origin)


def _as_arrays(name: str, positions, triangles, uv) -> tuple[np.ndarray, np.ndarray, np.ndarray | None]:
    """Check kinds and shapes of what a caller gives."""
    arrays = []
    for what, value, width, kinds in (("positions", positions, 3, "iuf"), ("triangles", triangles, 3, "iu"),
                                      ("uv", uv, 2, "iuf")):  # fmt: skip
        if what == "uv" and value is None:
            arrays.append(None)
            continue
        try:
            array = np.array(value)
        except ValueError:
            array = np.zeros(0)
        rows = len(positions) if what == "uv" else "N"
        if array.ndim != 2 or array.shape[1] != width or (what == "uv" and len(array) != len(positions)):
            raise InputError(f"mesh {name}: {what} of shape {array.shape}, expected [{rows}, {width}]")
        if array.dtype.kind not in kinds:
            expected = "whole numbers" if what == "triangles" else "numbers"
            raise InputError(f"mesh {name}: {what} of {array.dtype}, expected {expected}")
        arrays.append(array)
    return arrays[0], arrays[1], arrays[2]


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
    return assembled(RawMesh(positions, triangles, uv, normals), name, where or f"mesh {name}")[0]


def assembled(raw: RawMesh, name: str, where: str) -> tuple[Mesh, np.ndarray]:
    """Return a Mesh with frames from what a file holds, and which of its triangles [K] are in the mesh.

    Triangles without area and copies of others are left out; those that lie the other way round than their neighbours,
    or than the file's normals, are turned; a mesh far from the origin is moved to it. Raises InputError as `build_mesh`.
    """
    positions, triangles, origin = _checked(raw.positions, raw.triangles, where)
    _, place = distinct(positions)
    faces = Faces.of(positions, triangles)
    kept = dropped(place, triangles, faces.area)
    if not len(kept):
        raise InputError(f"{where}: every triangle has no area, there is nothing to see; mend the mesh")
    if len(kept) < len(triangles):
        faces = faces.some(kept)
    normals = None if raw.normals is None else np.asarray(raw.normals, np.float64)
    over = turned(place, faces.triangles, faces.area, normals)
    if over.any():
        faces = faces.turned(over)
    angles = faces.angles()
    N = _vertex_normals(len(positions), place, faces, angles, normals)
    rest = raw.parts if raw.part_of is not None else (), None if raw.part_of is None else raw.part_of[kept], origin
    if raw.uv is not None:
        uv = np.asarray(raw.uv, np.float64)
        tangent, corner_sign = _face_tangents(faces, uv, N)
        if corner_sign.any():
            triangles, sources, sign = _split_at_mirrors(faces.triangles, corner_sign.T, len(positions))
            uv = np.nan_to_num(uv[sources], nan=0.0, posinf=0.0, neginf=0.0)
            positions, N, place = positions[sources], N[sources], place[sources]
            weighted = tangent * angles[:, None]
            tangents = _tangents(place, faces.renumbered(triangles), N, uv, weighted, sign)
            return Mesh(name, positions, triangles, N, uv, tangents, *rest), kept
    tangents = np.column_stack([_fallback_tangents(N, _axis_order(faces, N)), np.ones(len(N))])
    return Mesh(name, positions, faces.triangles, N, None, tangents, *rest), kept


def _checked(
    positions: np.ndarray, triangles: np.ndarray, where: str
) -> tuple[np.ndarray, np.ndarray, tuple[float, float, float]]:
    """Return positions rounded to float32, triangles, and where their origin is; or raise InputError."""
    positions = np.asarray(positions, np.float64)
    triangles = np.asarray(triangles, np.int64)
    if len(triangles) == 0:
        raise InputError(f"{where}: holds no triangles; export it with its faces")
    check_counts(where, len(positions), len(triangles))
    if triangles.min() < 0 or triangles.max() >= len(positions):
        worst = triangles.min() if triangles.min() < 0 else triangles.max()
        raise InputError(
            f"{where}: a face names vertex {worst}, out of range, {len(positions)} defined; export it again"
        )
    bad = np.flatnonzero(~(np.abs(positions) < 1e38).all(axis=1))  # beyond, float32 has no number
    if len(bad):
        raise InputError(
            f"{where}: vertex {bad[0]} is ({', '.join(f'{c:g}' for c in positions[bad[0]])}), expected finite numbers; "
            "mend the mesh"
        )
    largest = float(np.abs(positions).max())
    if largest > LARGEST:
        raise InputError(f"{where}: coordinates up to {largest:g}, expected at most {LARGEST:g}; rescale the mesh")
    origin = _origin(positions, triangles)
    return (positions - origin).astype(np.float32).astype(np.float64), triangles, tuple(map(float, origin))


def _origin(positions: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """A point near the middle of a mesh that lies far from the origin, in round numbers; else the origin itself."""
    used = positions[triangles.ravel()] if len(triangles) < len(positions) else positions
    low, high = used.min(0), used.max(0)
    middle, radius = (low + high) / 2, np.linalg.norm(high - low) / 2
    if radius == 0 or np.linalg.norm(middle) <= FAR * radius:
        return np.zeros(3)
    unit = 2.0 ** np.floor(np.log2(radius))
    return np.round(middle / unit) * unit


def _split_at_mirrors(triangles: np.ndarray, corner_sign: np.ndarray, count: int) -> tuple[np.ndarray, ...]:
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


def _tangents(place, faces: Faces, N, uv, weighted, sign) -> np.ndarray:
    """Return tangents [V, 4] from those of corners [3, 3, T], alike at vertices with the same place, UVs, normal, sign."""
    _, group = distinct(np.column_stack([place, uv, N, sign]))
    summed = sums(group, faces.triangles, weighted)
    x = summed - N * np.sum(N * summed, axis=1, keepdims=True)
    length = np.linalg.norm(x, axis=1, keepdims=True)
    lost = length[:, 0] < 1e-6
    x = x / np.where(lost[:, None], 1.0, length)
    if lost.any():
        x[lost] = _fallback_tangents(N[lost], _axis_order(faces, N))
    return np.column_stack([x, sign])


def _unit(v: np.ndarray) -> np.ndarray:
    """Return v / |v| along the last axis; zero stays zero."""
    length = np.linalg.norm(v, axis=-1, keepdims=True)
    return v / np.where(length == 0, 1.0, length)


def _vertex_normals(
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


def _face_tangents(faces: Faces, uv: np.ndarray, N: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
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


def _axis_order(faces: Faces, N: np.ndarray) -> Sequence[int]:
    """Return the axes X, Z, Y (as 0, 2, 1), the one with the least area near it first."""
    area = np.sqrt(dot(faces.area, faces.area))
    facing = np.abs(N[faces.triangles].mean(axis=1)) > np.cos(np.radians(25.0))
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
