"""Mesh files and built-in meshes: load as cloth or as an object, save."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ..errors import InputError, meant
from ..files import PACKAGE, atomic_write, path_of, read_bytes
from ..progress import warn
from . import shapes
from .gltf_scene import read_gltf
from .materials import colors_at, mean_color
from .mesh import Mesh, assembled, build_mesh
from .mesh_write import glb_bytes, obj_text, ply_bytes
from .obj import read_obj
from .pieces import SAMPLES, load_piece
from .ply import read_ply
from .raw import MOST_BYTES, Material, RawMesh
from .spline import surface_mesh
from .stl_off import read_off, read_stl
from .supports import backdrop, form, pedestal, together

MESHES = PACKAGE / "meshes"
BUILTIN_MESHES = ("drape", "drape_smooth", *SAMPLES, "sphere", "plane", "cylinder")
SUPPORTS = {"form": form, "pedestal": pedestal, "backdrop": backdrop}
BUILTIN_SOLIDS = ("stand", *SUPPORTS)  # objects only
MESH_SUFFIXES = (".obj", ".ply", ".glb", ".gltf", ".stl", ".off")
SAVE_SUFFIXES = (".ply", ".obj", ".glb")
GREY = 0.5  # reflectance of an object whose file gives no colour
# The built-in cloth was draped over a box (centre, outer half sides, rounding) whose top is y = 0, and a ball (centre,
# radius) that stands on it, a hand from its edge; metres. glcloth/simulation/drape.py simulates with them.
TABLE = (0.0, -0.35, -0.6), (1.2, 0.35, 0.65), 0.03
BALL = (-0.04, 0.15, -0.16), 0.19
PLINTH = -1.208  # its lower end: under the hem
ROUNDING = 0.004  # of its other edges
# The built-in cloth is a grid of so many vertices a side, m wide; a spline over them, sampled more finely, has no dashes along
# its creases.
DRAPE_GRID, DRAPE_SIDE, DRAPE_SMOOTH = 150, 1.6, 236


def load_mesh(name_or_path: str | Path) -> Mesh:
    """Load a built-in mesh by name, or a mesh file (OBJ, PLY, glTF, GLB, STL, OFF), and give it yarn frames.

    Vertices keep the file's order; ones that must be split are appended. All geometries of a scene are joined, with
    their transforms. Raises InputError for an unknown name or suffix and for a file that is missing, damaged, or holds
    no triangles, numbers that are not finite, or indices out of range.
    """
    mesh = _load(name_or_path, False)[0]
    if mesh.uv is None:
        warn(
            f"{name_or_path}: no usable UVs, so yarn 1 follows a projected world axis; add UVs to lay the cloth yourself"
        )
    return mesh


def load_solid(name_or_path: str | Path) -> tuple[Mesh, np.ndarray]:
    """Load a mesh as `load_mesh` does, as an object that is no cloth, and the diffuse reflectance [T, 3] (linear) of its
    triangles: Kd of an OBJ's materials, the base colour of a glTF's, a PLY's colours, else GREY. Raises InputError as
    `load_mesh`, and for materials that are missing or damaged."""
    return load_object(name_or_path)[:2]


def load_object(name_or_path: str | Path) -> tuple[Mesh, np.ndarray, tuple[Material, ...], np.ndarray]:
    """As `load_solid`, with the materials of the file and the number [T] of each triangle's among them."""
    mesh, colors, materials, material_of = _load(name_or_path, True)
    assert colors is not None
    numbers = np.zeros(len(mesh.triangles), np.int32) if material_of is None else material_of
    return mesh, colors, materials or (Material(),), numbers


class _Loaded(NamedTuple):
    """A mesh and, of an object, the reflectances [T, 3] of its triangles, its materials and the number [T] of each one's."""

    mesh: Mesh
    colors: np.ndarray | None = None
    materials: tuple[Material, ...] = ()
    material_of: np.ndarray | None = None


def _load(name_or_path: str | Path, colored: bool) -> _Loaded:
    """A mesh by name or file, and its looks if asked for."""
    path = path_of(name_or_path)
    names = (*BUILTIN_MESHES, *BUILTIN_SOLIDS) if colored else BUILTIN_MESHES
    if str(name_or_path) in names and path.parent == Path("."):
        return _builtin_with_colors(str(name_or_path))
    if not path.suffix and not path.exists():
        hint = meant(str(name_or_path), names, "did you mean {}?") or f"built in are {', '.join(names)}; or give a file"
        raise InputError(f"mesh {name_or_path}: neither a built-in mesh nor a file; {hint}")
    if path.is_dir():
        raise InputError(f"{path}: is a folder, expected a mesh file ({', '.join(MESH_SUFFIXES)})")
    suffix = path.suffix.lower()
    if suffix not in MESH_SUFFIXES:
        raise InputError(
            f"{path}: unknown suffix `{path.suffix}`, expected {', '.join(MESH_SUFFIXES)}; convert it first"
        )
    raw = read_mesh(path, colored)
    mesh, kept = assembled(raw, path.stem, str(path))
    if any(mesh.origin) and not colored:
        by = ", ".join(f"{0 - c:g}" for c in mesh.origin)
        warn(f"{path}: lies far from the origin, where numbers are too coarse; moved by {by} m")
    if not colored:
        return _Loaded(mesh)
    material_of = None if raw.material_of is None else raw.material_of[kept]
    return _Loaded(mesh, reflectances(raw, str(path))[kept], tuple(raw.materials or ()), material_of)


def read_mesh(path: Path, colored: bool = False) -> RawMesh:
    """Return what a mesh file holds as it stands in it, with its materials if asked for. Raises InputError."""
    if not path.exists():
        raise InputError(f"{path}: no such file; check the path, or use a built-in mesh ({', '.join(BUILTIN_MESHES)})")
    blob = read_bytes(path, MOST_BYTES)
    if not blob.strip():
        raise InputError(f"{path}: the file is empty; export the mesh again")
    if path.suffix.lower() == ".obj":
        return read_obj(blob, path, colored)
    suffix = path.suffix.lower()
    if suffix in (".glb", ".gltf"):
        return read_gltf(blob, path, colored)
    return {".ply": read_ply, ".stl": read_stl, ".off": read_off}[suffix](blob, str(path))


def reflectances(raw: RawMesh, where: str) -> np.ndarray:
    """The diffuse reflectance [T, 3] float32, linear, of triangles: their materials' colours, pictures coarsely or by
    their mean."""
    rows = np.full((len(raw.triangles), 3), GREY if raw.colors is None else 1.0)
    if raw.materials and raw.material_of is not None:
        rows = np.zeros((len(raw.triangles), 3))
        for number, material in enumerate(raw.materials):
            mine = raw.material_of == number
            found = None if raw.uv is None else colors_at(material, raw.uv[raw.triangles[mine]], where)
            rows[mine] = mean_color(material, where) if found is None else found
    return (rows if raw.colors is None else rows * raw.colors).astype(np.float32)


def load_view(name: str) -> dict | None:
    """Return eye, target, up (3 numbers each, m) and fov_deg of a built-in mesh's camera, or None for other names."""
    return tomllib.loads((MESHES / "views.toml").read_text(encoding="utf-8")).get(name)


def _builtin_with_colors(name: str) -> _Loaded:
    if name == "stand":
        return _Loaded(*_stand())
    if name in SUPPORTS:
        return _Loaded(*SUPPORTS[name]())
    mesh = _builtin(name)
    return _Loaded(mesh, np.full((len(mesh.triangles), 3), GREY, np.float32))


def _builtin(name: str) -> Mesh:
    if name == "drape":
        return assembled(read_mesh(MESHES / "drape.ply"), name, name)[0]
    if name == "drape_smooth":
        vertices = read_mesh(MESHES / "drape.ply").positions.reshape(DRAPE_GRID, DRAPE_GRID, 3)
        return surface_mesh(name, vertices, (DRAPE_SIDE, DRAPE_SIDE), DRAPE_SMOOTH, DRAPE_SMOOTH)
    if name in SAMPLES:
        return load_piece(name, MESHES)
    positions, triangles, uv, normals = getattr(shapes, name)()
    return build_mesh(name, positions, triangles, uv, normals)


def _stand() -> tuple[Mesh, np.ndarray]:
    """The support of the built-in cloth: the ball and the table that it was draped over, and a plinth down to its hem."""
    low = TABLE[0][1] - TABLE[1][1]
    # No rounding where it stands: a crack of 4 mm over a floor is a line of dashes from afar.
    plinth = np.array([[-1.1, PLINTH - ROUNDING, -1.15], [1.1, low + 0.02, 0.0]])
    box, box_triangles, box_N = shapes.rounded_box(plinth.mean(0), (plinth[1] - plinth[0]) / 2, ROUNDING, 0.08, 1)
    box[:, 1] = np.maximum(box[:, 1], PLINTH)
    x, triangles, _, N = shapes.sphere(BALL[1], 40, 80)
    parts = [
        (shapes.rounded_box(*TABLE, 0.045), (0.34, 0.22, 0.13)),
        ((box, box_triangles, box_N), (0.20, 0.18, 0.17)),
        ((x + BALL[0], triangles, N), (0.55, 0.53, 0.50)),
    ]
    return together("stand", parts)


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
            temporary.write_bytes(ply_bytes(mesh))
        elif suffix == ".obj":
            temporary.write_text(obj_text(mesh), encoding="utf-8")
        else:
            temporary.write_bytes(glb_bytes(mesh))
