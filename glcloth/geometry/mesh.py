"""Triangle meshes with a yarn frame at every vertex: load, build, save.

The frame is (x, y, N): x = yarn 1 = the direction of growing u in the tangent plane, y = yarn 2 = w cross(N, x) with
w = -1 where the UVs are mirrored. A vertex where mirrored and unmirrored triangles meet is split in two.

Without UVs yarn 1 is a world axis projected into the tangent plane: of +X, +Z, +Y the first one that the fewest
normals (by area) lie near. The field is continuous except where a normal is parallel to that axis; there the next
axis serves. `load_mesh` says so in one warning.
"""

from __future__ import annotations

import difflib
import tomllib
import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import trimesh

from ..color import srgb_decode
from ..errors import InputError
from ..files import PACKAGE, atomic_write
from ..progress import warn
from . import shapes
from .obj import read_obj, read_obj_and_mtl, split_vertices

MESHES = PACKAGE / "meshes"
BUILTIN_MESHES = ("drape", "sphere", "plane", "cylinder")
BUILTIN_SOLIDS = ("stand",)  # objects only
MESH_SUFFIXES = (".obj", ".ply", ".glb", ".gltf", ".stl", ".off")
GREY = 0.5  # reflectance of an object whose file tells of no colour
# What the built-in cloth was draped over: a box (centre, outer half sides, rounding) whose top is y = 0, and a ball
# (centre, radius) that stands on it, a hand from its edge; metres. glcloth/simulation/drape.py simulates with them.
TABLE = (0.0, -0.35, -0.6), (1.2, 0.35, 0.65), 0.03
BALL = (-0.04, 0.15, -0.16), 0.19
PLINTH = -1.208  # its lower end: under the hem
LARGEST = 1e9  # beyond it float32 leaves no digits for a cloth
SAVE_SUFFIXES = (".ply", ".obj", ".glb")


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
    def radius(self) -> float:
        """Return the radius of the sphere about `center` that holds every triangle."""
        used = self._used()
        return float(np.linalg.norm(used - self.center, axis=1).max())


def load_mesh(name_or_path: str | Path) -> Mesh:
    """Load a built-in mesh by name, or a mesh file (OBJ, PLY, glTF, GLB, STL, OFF), and give it yarn frames.

    Vertices keep the file's order; ones that must be split are appended. All geometries of a scene are joined, with
    their transforms. Raises InputError for an unknown name or suffix and for a file that is missing, damaged, or holds
    no triangles, numbers that are not finite, or indices out of range.
    """
    mesh, _ = _load(name_or_path, False)
    if mesh.uv is None:
        warn(
            f"{name_or_path}: no usable UVs, so yarn 1 follows a projected world axis; add UVs to lay the cloth yourself"
        )
    return mesh


def load_solid(name_or_path: str | Path) -> tuple[Mesh, np.ndarray]:
    """Load a mesh as `load_mesh` does, as an object that is no cloth, and the diffuse reflectance [T, 3] (linear) of its
    triangles: Kd of an OBJ's materials, the base colour of a glTF's, a PLY's colours, else GREY. Raises InputError as
    `load_mesh`, and for materials that are missing or damaged."""
    return _load(name_or_path, True)


def _load(name_or_path: str | Path, colored: bool) -> tuple[Mesh, np.ndarray | None]:
    """A mesh and, if asked for, the reflectances [T, 3] of its triangles."""
    path = Path(name_or_path)
    if str(name_or_path) in BUILTIN_MESHES and path.parent == Path("."):
        mesh = _builtin(str(name_or_path))
        return mesh, np.full((len(mesh.triangles), 3), GREY, np.float32)
    names = (*BUILTIN_MESHES, *BUILTIN_SOLIDS) if colored else BUILTIN_MESHES
    if colored and str(name_or_path) == "stand" and path.parent == Path("."):
        return _stand()
    if not path.suffix and not path.exists():
        close = difflib.get_close_matches(str(name_or_path), names, 1)
        hint = f"did you mean {close[0]}?" if close else f"built in are {', '.join(names)}; or give a file"
        raise InputError(f"mesh {name_or_path}: neither a built-in mesh nor a file; {hint}")
    if path.is_dir():
        raise InputError(f"{path}: is a folder, expected a mesh file ({', '.join(MESH_SUFFIXES)})")
    suffix = path.suffix.lower()
    if suffix not in MESH_SUFFIXES:
        raise InputError(
            f"{path}: unknown suffix `{path.suffix}`, expected {', '.join(MESH_SUFFIXES)}; convert it first"
        )
    if not path.is_file():
        raise InputError(f"{path}: no such file; check the path, or use a built-in mesh ({', '.join(BUILTIN_MESHES)})")
    try:
        blob = path.read_bytes()
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror}); check its permissions") from None
    if not blob.strip():
        raise InputError(f"{path}: the file is empty; export the mesh again")
    if suffix == ".obj" and colored:
        data, reflectances = read_obj_and_mtl(path, GREY)
        colors = reflectances[data.material]
    elif suffix == ".obj":
        data, colors = read_obj(blob.decode("utf-8", errors="replace"), str(path)), None
    if suffix == ".obj":
        arrays = data.positions, data.triangles, data.uv, data.normals
    else:
        *arrays, colors = _read_with_trimesh(path, colored)
    return build_mesh(path.stem, *arrays, where=str(path)), colors


def load_view(name: str) -> dict | None:
    """Return eye, target, up (3 numbers each, m) and fov_deg of a built-in mesh's camera, or None for other names."""
    return tomllib.loads((MESHES / "views.toml").read_text(encoding="utf-8")).get(name)


def _builtin(name: str) -> Mesh:
    if name == "drape":
        return build_mesh(name, *_read_with_trimesh(MESHES / "drape.ply")[:4], where=name)
    positions, triangles, uv, normals = getattr(shapes, name)()
    return build_mesh(name, positions, triangles, uv, normals)


def _stand() -> tuple[Mesh, np.ndarray]:
    """What the built-in cloth lies on: the ball and the table that it was draped over, and a plinth down to its hem."""
    low = TABLE[0][1] - TABLE[1][1]
    plinth = np.array([[-1.1, PLINTH, -1.15], [1.1, low + 0.02, 0.0]])
    x, triangles, _, N = shapes.sphere(BALL[1], 40, 80)
    parts = [
        (shapes.rounded_box(*TABLE, 0.045), (0.34, 0.22, 0.13)),
        (shapes.rounded_box(plinth.mean(0), (plinth[1] - plinth[0]) / 2, 0.004, 0.08, 1), (0.20, 0.18, 0.17)),
        ((x + BALL[0], triangles, N), (0.55, 0.53, 0.50)),
    ]
    firsts = np.cumsum([0, *(len(part[0]) for part, _ in parts)])
    mesh = build_mesh(
        "stand",
        np.concatenate([part[0] for part, _ in parts]),
        np.concatenate([part[1] + first for (part, _), first in zip(parts, firsts, strict=False)]),
        None,
        np.concatenate([part[2] for part, _ in parts]),
    )
    return mesh, np.concatenate([np.tile(np.float32(color), (len(part[1]), 1)) for part, color in parts])


def _read_with_trimesh(path: Path, colored: bool = False) -> tuple[np.ndarray | None, ...]:
    """Return (positions, triangles, uv or None, normals or None, reflectances [T, 3] if asked for) of all geometries of a
    file, in the world frame."""
    try:
        # trimesh warns of what it can mend (missing textures, say); what it cannot raises errors of any type.
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            scene = trimesh.load_scene(path, process=False, fix_texture=not _ply_has_vertex_uv(path))
            parts = [_part(scene, node, colored) for node in scene.graph.nodes_geometry]
    except InputError:
        raise
    except Exception as error:
        reason = " ".join(str(error).split())[:100] or type(error).__name__
        kind = path.suffix.lower().lstrip(".")
        raise InputError(f"{path}: cannot be read as {kind} ({reason}); is it whole? export it again") from None
    parts = [part for part in parts if part is not None]
    if not parts:
        raise InputError(f"{path}: holds no triangles; export it with its faces")
    begins = np.cumsum([0] + [len(part[0]) for part in parts])
    triangles = []
    for (positions, faces, *_), begin in zip(parts, begins, strict=False):
        if len(faces) and (faces.min() < 0 or faces.max() >= len(positions)):
            raise InputError(
                f"{path}: a face names vertex {faces.max()}, out of range, it has {len(positions)}; export it again"
            )
        triangles.append(faces + begin)

    def joined(column: int, width: int) -> np.ndarray | None:
        if all(part[column] is None for part in parts):
            return None
        return np.concatenate(
            [np.full((len(part[0]), width), np.nan) if part[column] is None else part[column] for part in parts]
        )

    colors = np.concatenate([part[4] for part in parts]).astype(np.float32) if colored else None
    return np.concatenate([part[0] for part in parts]), np.concatenate(triangles), joined(2, 2), joined(3, 3), colors


def _ply_has_vertex_uv(path: Path) -> bool:
    """Return whether a PLY header declares UVs per vertex: then trimesh must not regroup (and reorder) the vertices."""
    if path.suffix.lower() != ".ply":
        return False
    with open(path, "rb") as file:
        header = file.read(1 << 16).split(b"end_header", 1)[0]
    names = {line.split()[-1] for line in header.splitlines() if line.startswith(b"property") and b" list " not in line}
    return any(pair <= names for pair in ({b"s", b"t"}, {b"u", b"v"}, {b"texture_u", b"texture_v"}))


def _part(scene: trimesh.Scene, node: str, colored: bool) -> tuple | None:
    """Return one node's arrays in the world frame, or None if it is no surface."""
    world_from_part, name = scene.graph[node]
    geometry = scene.geometry[name]
    if not isinstance(geometry, trimesh.Trimesh) or len(geometry.faces) == 0:
        return None
    linear = np.asarray(world_from_part)[:3, :3]
    positions = np.asarray(geometry.vertices, float) @ linear.T + np.asarray(world_from_part)[:3, 3]
    faces = np.asarray(geometry.faces, np.int64)
    uv = getattr(geometry.visual, "uv", None)
    if uv is not None and np.shape(uv) != (len(positions), 2):
        uv = None
    # Asking for vertex_normals would make trimesh compute them; only what the file gave is in the cache.
    normals = geometry._cache.cache.get("vertex_normals")
    if normals is not None and np.shape(normals) == positions.shape:
        normals = np.asarray(normals, float) @ np.linalg.pinv(linear)
    else:
        normals = None
    # A mirroring transform turns triangles inside out; swapping two corners turns them back.
    if np.linalg.det(linear) < 0:
        faces = faces[:, ::-1]
    return positions, faces, uv, normals, _reflectances(geometry) if colored else None


def _reflectances(geometry: trimesh.Trimesh) -> np.ndarray:
    """Return the diffuse reflectance [F, 3], linear, of a geometry's faces; GREY where the file says nothing."""
    count, visual = len(geometry.faces), geometry.visual
    if not getattr(visual, "defined", False):
        return np.full((count, 3), GREY)
    if visual.kind == "face":
        return srgb_decode(np.asarray(visual.face_colors)[:, :3] / 255.0)
    if visual.kind == "vertex":
        return srgb_decode(np.asarray(visual.vertex_colors)[:, :3] / 255.0)[geometry.faces].mean(1)
    material = getattr(visual, "material", None)
    if isinstance(material, trimesh.visual.material.PBRMaterial):
        factor, texture = material.baseColorFactor, material.baseColorTexture
        # A factor is linear, a texture's texels are not.
        color = np.ones(3) if factor is None else np.asarray(factor, float)[:3] / 255.0
        if texture is not None:
            color = color * srgb_decode(np.asarray(texture.convert("RGB"), float) / 255.0).mean((0, 1))
        elif factor is None:
            color = np.full(3, GREY)
    else:
        color = srgb_decode(np.asarray(getattr(material, "main_color", [188, 188, 188]), float)[:3] / 255.0)
    return np.tile(color, (count, 1))


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
    where = where or f"mesh {name}"
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
    N = _vertex_normals(positions, triangles, normals)
    sources = np.arange(len(positions))
    face_sign = None
    if uv is not None:
        uv = np.asarray(uv, np.float64)
        corner_tangent, corner_sign = _corner_tangents(positions, triangles, uv, N)
        if not corner_sign.any():
            uv = None
        else:
            # Corners without a sign (degenerate UVs) go with whatever their vertex has.
            flat = triangles.ravel()
            sign = corner_sign.ravel().copy()
            known = np.zeros(len(positions))
            known[flat[::-1][sign[::-1] != 0]] = sign[::-1][sign[::-1] != 0]
            sign = np.where(sign == 0, np.where(known[flat] == 0, 1, known[flat]), sign).astype(np.int64)
            corner, sources, first = split_vertices(flat, sign[:, None], len(positions))
            triangles = corner.reshape(-1, 3)
            face_sign = np.where(first < 0, 1, sign[first])
    positions, N = positions[sources], N[sources]
    if uv is None:
        tangents = np.column_stack([_fallback_tangents(N, _axis_order(positions, triangles, N)), np.ones(len(N))])
    else:
        uv = np.nan_to_num(uv[sources], nan=0.0, posinf=0.0, neginf=0.0)
        summed = _sum_at_coincident(
            np.column_stack([positions, uv, N, face_sign]), triangles.ravel(), corner_tangent.reshape(-1, 3)
        )
        x = summed - N * np.sum(N * summed, axis=1, keepdims=True)
        length = np.linalg.norm(x, axis=1, keepdims=True)
        lost = length[:, 0] < 1e-6
        x = x / np.where(lost[:, None], 1.0, length)
        if lost.any():
            x[lost] = _fallback_tangents(N[lost], _axis_order(positions, triangles, N))
        tangents = np.column_stack([x, face_sign])
    return Mesh(name, positions, triangles, N, uv, tangents)


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


def save_mesh(path: str | Path, mesh: Mesh) -> None:
    """Write a mesh with normals and UVs as binary PLY, OBJ or GLB, by the suffix; whole or not at all.

    Raises InputError for another suffix, or a path that cannot be written.
    """
    path = Path(path)
    suffix = path.suffix.lower()
    if suffix not in SAVE_SUFFIXES:
        raise InputError(f"{path}: cannot save a mesh as `{path.suffix}`, expected {', '.join(SAVE_SUFFIXES)}")
    with atomic_write(path) as temporary:
        if suffix == ".ply":
            temporary.write_bytes(_ply(mesh))
        elif suffix == ".obj":
            temporary.write_text(_obj(mesh), encoding="utf-8")
        else:
            visual = None if mesh.uv is None else trimesh.visual.TextureVisuals(uv=mesh.uv)
            whole = trimesh.Trimesh(
                mesh.positions, mesh.triangles, vertex_normals=mesh.normals, visual=visual, process=False
            )
            temporary.write_bytes(trimesh.Scene({mesh.name: whole}).export(file_type="glb"))


def _ply(mesh: Mesh) -> bytes:
    """Return binary little-endian PLY: x y z nx ny nz [s t] per vertex, one list of three indices per face."""
    names = ["x", "y", "z", "nx", "ny", "nz"] + ([] if mesh.uv is None else ["s", "t"])
    header = ["ply", "format binary_little_endian 1.0", f"element vertex {len(mesh.positions)}"]
    header += [f"property float {name}" for name in names]
    header += [f"element face {len(mesh.triangles)}", "property list uchar int vertex_indices", "end_header", ""]
    vertex = np.column_stack([mesh.positions, mesh.normals] + ([] if mesh.uv is None else [mesh.uv])).astype("<f4")
    face = np.empty(len(mesh.triangles), np.dtype([("count", "u1"), ("index", "<i4", (3,))]))
    face["count"], face["index"] = 3, mesh.triangles
    return "\n".join(header).encode() + vertex.tobytes() + face.tobytes()


def _obj(mesh: Mesh) -> str:
    """Return OBJ text; nine significant digits give back every float32."""
    lines = [f"o {mesh.name}"]
    lines += ["v {:.9g} {:.9g} {:.9g}".format(*row) for row in mesh.positions.tolist()]
    lines += [] if mesh.uv is None else ["vt {:.9g} {:.9g}".format(*row) for row in mesh.uv.tolist()]
    lines += ["vn {:.9g} {:.9g} {:.9g}".format(*row) for row in mesh.normals.tolist()]
    corner = "{0}//{0}" if mesh.uv is None else "{0}/{0}/{0}"
    lines += ["f " + " ".join(corner.format(i + 1) for i in row) for row in mesh.triangles.tolist()]
    return "\n".join([*lines, ""])
