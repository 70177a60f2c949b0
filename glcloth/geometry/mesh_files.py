"""Mesh files and built-in meshes: load as cloth or as an object, save."""

from __future__ import annotations

import difflib
import tomllib
import warnings
from pathlib import Path

import numpy as np
import trimesh

from ..color import srgb_decode
from ..errors import InputError
from ..files import PACKAGE, atomic_write, read_bytes
from ..progress import warn
from . import shapes
from .mesh import Mesh, assembled, build_mesh
from .obj import read_obj
from .raw import MOST_BYTES, Material, RawMesh, joined

MESHES = PACKAGE / "meshes"
BUILTIN_MESHES = ("drape", "sphere", "plane", "cylinder")
BUILTIN_SOLIDS = ("stand",)  # objects only
MESH_SUFFIXES = (".obj", ".ply", ".glb", ".gltf", ".stl", ".off")
SAVE_SUFFIXES = (".ply", ".obj", ".glb")
GREY = 0.5  # reflectance of an object whose file gives no colour
# The built-in cloth was draped over a box (centre, outer half sides, rounding) whose top is y = 0, and a ball (centre,
# radius) that stands on it, a hand from its edge; metres. glcloth/simulation/drape.py simulates with them.
TABLE = (0.0, -0.35, -0.6), (1.2, 0.35, 0.65), 0.03
BALL = (-0.04, 0.15, -0.16), 0.19
PLINTH = -1.208  # its lower end: under the hem


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
    raw = read_mesh(path, colored)
    mesh, kept = assembled(raw, path.stem, str(path))
    return mesh, reflectances(raw)[kept] if colored else None


def read_mesh(path: Path, colored: bool = False) -> RawMesh:
    """Return what a mesh file holds as it stands in it, with its materials if asked for. Raises InputError."""
    if not path.exists():
        raise InputError(f"{path}: no such file; check the path, or use a built-in mesh ({', '.join(BUILTIN_MESHES)})")
    blob = read_bytes(path, MOST_BYTES)
    if not blob.strip():
        raise InputError(f"{path}: the file is empty; export the mesh again")
    if path.suffix.lower() == ".obj":
        return read_obj(blob, path, colored)
    return _read_with_trimesh(path, colored)


def reflectances(raw: RawMesh) -> np.ndarray:
    """The diffuse reflectance [T, 3] float32, linear, of triangles: their materials' colours, textures by their mean."""
    if not raw.materials and raw.colors is None:
        return np.full((len(raw.triangles), 3), GREY, np.float32)
    rows = np.ones((len(raw.triangles), 3))
    if raw.materials and raw.material_of is not None:
        rows = np.array([material.color for material in raw.materials])[raw.material_of]
    return (rows if raw.colors is None else rows * raw.colors).astype(np.float32)


def load_view(name: str) -> dict | None:
    """Return eye, target, up (3 numbers each, m) and fov_deg of a built-in mesh's camera, or None for other names."""
    return tomllib.loads((MESHES / "views.toml").read_text(encoding="utf-8")).get(name)


def _builtin(name: str) -> Mesh:
    if name == "drape":
        return assembled(_read_with_trimesh(MESHES / "drape.ply"), name, name)[0]
    positions, triangles, uv, normals = getattr(shapes, name)()
    return build_mesh(name, positions, triangles, uv, normals)


def _stand() -> tuple[Mesh, np.ndarray]:
    """The support of the built-in cloth: the ball and the table that it was draped over, and a plinth down to its hem."""
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


def _read_with_trimesh(path: Path, colored: bool = False) -> RawMesh:
    try:
        # trimesh warns of faults that it can mend (missing textures, say); others raise errors of any type.
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
    return joined([part for part in parts if part is not None], str(path))


def _ply_has_vertex_uv(path: Path) -> bool:
    """Return whether a PLY header declares UVs per vertex: then trimesh must not regroup (and reorder) the vertices."""
    if path.suffix.lower() != ".ply":
        return False
    with open(path, "rb") as file:
        header = file.read(1 << 16).split(b"end_header", 1)[0]
    names = {line.split()[-1] for line in header.splitlines() if line.startswith(b"property") and b" list " not in line}
    return any(pair <= names for pair in ({b"s", b"t"}, {b"u", b"v"}, {b"texture_u", b"texture_v"}))


def _part(scene: trimesh.Scene, node: str, colored: bool) -> RawMesh | None:
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
    material = getattr(getattr(geometry.visual, "material", None), "name", None) or ""
    names = tuple(dict.fromkeys(n for n in (str(material), name, str(node)) if n))
    which = np.zeros(len(faces), np.int32)
    materials = (Material(str(material)),)
    return RawMesh(positions, faces, uv, normals, (names,), which, materials, which, _reflectances(geometry))


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
