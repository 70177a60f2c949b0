"""A triangle mesh with a yarn frame at every vertex, and how it is made of arrays; `yarn_frames` says what the frames are."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..errors import InputError
from .coincident import distinct
from .faces import Faces
from .raw import Names, RawMesh, check_counts
from .winding import dropped, turned
from .yarn_frames import (
    axis_order,
    face_tangents,
    projected_axes,
    split_at_mirrors,
    vertex_normals,
    vertex_tangents,
)

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
        N = vertex_normals(len(positions), place, new, angles, None)
        sign = self.tangents[:, 3].astype(float)
        if self.uv is None:
            tangents = np.column_stack([projected_axes(N, axis_order(new, N)), sign])
        else:
            uv = self.uv.astype(float)
            weighted = face_tangents(new, uv, N)[0] * angles[:, None]
            tangents = vertex_tangents(place, new, N, uv, weighted, sign)
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
    N = vertex_normals(len(positions), place, faces, angles, normals)
    rest = raw.parts if raw.part_of is not None else (), None if raw.part_of is None else raw.part_of[kept], origin
    if raw.uv is not None:
        uv = np.asarray(raw.uv, np.float64)
        tangent, corner_sign = face_tangents(faces, uv, N)
        if corner_sign.any():
            triangles, sources, sign = split_at_mirrors(faces.triangles, corner_sign.T, len(positions))
            uv = np.nan_to_num(uv[sources], nan=0.0, posinf=0.0, neginf=0.0)
            positions, N, place = positions[sources], N[sources], place[sources]
            weighted = tangent * angles[:, None]
            tangents = vertex_tangents(place, faces.renumbered(triangles), N, uv, weighted, sign)
            return Mesh(name, positions, triangles, N, uv, tangents, *rest), kept
    tangents = np.column_stack([projected_axes(N, axis_order(faces, N)), np.ones(len(N))])
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
