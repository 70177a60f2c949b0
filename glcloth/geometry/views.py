"""Views by name: of any cloth by its size, and the cameras that a glTF file brings."""

from __future__ import annotations

import difflib
import json
import struct
from functools import lru_cache
from pathlib import Path

import numpy as np
from pyrr import vector

from ..errors import InputError
from .camera import Camera

# From where each view looks: x right, y up, z to the front.
DIRECTIONS = {
    "front": (0.0, 0.0, 1.0),
    "three-quarter": (0.75, 0.3, 1.0),
    "side": (1.0, 0.0, 0.0),
    "back": (0.0, 0.0, -1.0),
    "close": (0.3, 0.25, 1.0),
}
FILE = "file"  # the name of the only camera of a file, whatever it is called there
MARGIN = 1.06  # of the picture's height and width, about what it frames
CLOSE = 0.25  # of the cloth's radius is the height of a close view
CAMERA_FILES = (".glb", ".gltf")


def view_by_name(
    name: str,
    points: np.ndarray,
    aspect: float,
    fov_deg: float = 35.0,
    ortho: float | None = None,
    file: str | Path | None = None,
) -> Camera:
    """The camera of a name: one of DIRECTIONS, or one of the file's.

    Parameters
    ----------
    points : [V, 3] of what it frames, metres
    aspect : width over height of the picture
    fov_deg, ortho : of the view, as for `Camera`; a file's camera has its own
    file : from which `points` were read

    Raises InputError for a name that neither has.
    """
    points = np.asarray(points, float)
    if name in DIRECTIONS:
        return (_close if name == "close" else _framing)(DIRECTIONS[name], points, aspect, fov_deg, ortho)
    path = Path(file) if file is not None else Path()
    known = (
        file_cameras(path, path.stat().st_mtime_ns) if path.suffix.lower() in CAMERA_FILES and path.is_file() else {}
    )
    if name == FILE and len(known) == 1:
        name = next(iter(known))
    if name not in known:
        names = [*DIRECTIONS, *known]
        close = difflib.get_close_matches(name, names, 1)
        hint = f"did you mean {close[0]}? " if close else ""
        has = f"{path} has {len(known)} cameras; " if path.suffix.lower() in CAMERA_FILES else ""
        raise InputError(f"camera: view {name!r}: unknown; {has}{hint}expected {', '.join(names)}")
    return _toward(known[name], points)


def _framing(direction, points: np.ndarray, aspect: float, fov_deg: float, ortho: float | None) -> Camera:
    """All points in the picture, seen from a direction."""
    middle = (points.min(0) + points.max(0)) / 2
    toward = vector.normalise(np.asarray(direction, float))
    right, up, _ = Camera(tuple(middle + toward), tuple(middle)).axes
    x, y, z = np.abs((points - middle) @ right), np.abs((points - middle) @ up), (points - middle) @ toward
    half = MARGIN * max(float(y.max()), float(x.max()) / aspect, 1e-6)
    tangent = np.tan(np.radians(fov_deg) / 2)
    distance = max(float((MARGIN * y / tangent + z).max()), float((MARGIN * x / (tangent * aspect) + z).max()))
    if ortho is not None:
        distance = float(np.abs(z).max()) + 2.0 * half
    eye = middle + toward * max(distance, 1e-3 * half + float(z.max()))
    return Camera(tuple(eye), tuple(middle), (0.0, 1.0, 0.0), fov_deg, ortho)


def _close(direction, points: np.ndarray, aspect: float, fov_deg: float, ortho: float | None) -> Camera:
    """A part in the middle, seen from a direction."""
    middle = (points.min(0) + points.max(0)) / 2
    radius = float(np.linalg.norm(points - middle, axis=1).max())
    toward = vector.normalise(np.asarray(direction, float))
    depth = (points - middle) @ toward
    beside = np.linalg.norm(points - middle - depth[:, None] * toward, axis=1)
    # Of the points that the middle of the picture shows, the nearest; of a cloth with a hole there, those next to it.
    shown = beside <= max(0.5 * CLOSE * radius, 1.01 * float(beside.min()))
    target = points[shown][depth[shown].argmax()]
    half = max(0.5 * CLOSE * radius, 1e-6)
    distance = half / np.tan(np.radians(fov_deg) / 2) if ortho is None else 2.0 * radius
    return Camera(tuple(target + toward * distance), tuple(target), (0.0, 1.0, 0.0), fov_deg, ortho)


def _toward(camera: Camera, points: np.ndarray) -> Camera:
    """A file's camera, which has a direction only, with its target beside the middle of the points."""
    forward = camera.axes[2]
    distance = float(((points.min(0) + points.max(0)) / 2 - camera.eye) @ forward)
    size = float(np.linalg.norm(points.max(0) - points.min(0)))
    target = np.asarray(camera.eye) + forward * max(distance, 0.05 * size, 1e-6)
    return Camera(camera.eye, tuple(target), camera.up, camera.fov_deg, camera.ortho)


# -- cameras of a glTF file ----------------------------------------------------------------------------------------------


@lru_cache(maxsize=4)
def file_cameras(path: Path, _changed: int = 0) -> dict[str, Camera]:
    """The cameras of a .glb or .gltf file by name, with their nodes' transforms; targets are one metre before them.

    glTF 2.0, section 3.10: a camera looks along -z of its node, +y is up; `yfov` is the vertical angle of view, `ymag` half
    the height. Raises InputError for a file that cannot be read.
    """
    data = _json_of(path)
    try:
        return dict(_cameras(data))
    except (KeyError, IndexError, TypeError, ValueError, RecursionError):
        raise InputError(f"{path}: its cameras cannot be read; export it again, or give --eye and --target") from None


def _json_of(path: Path) -> dict:
    try:
        with open(path, "rb") as file:
            if path.suffix.lower() == ".glb":
                magic, _, _, length, _ = struct.unpack("<4sIII4s", file.read(20))
                if magic != b"glTF":
                    raise ValueError
                return json.loads(file.read(length))
            return json.load(file)
    except (OSError, ValueError, struct.error):
        raise InputError(f"{path}: cannot be read as glTF; export it again") from None


def _cameras(data: dict):
    """(name, camera) of each node with a camera."""
    nodes = data.get("nodes", [])
    above = {child: number for number, node in enumerate(nodes) for child in node.get("children", [])}
    used: dict[str, int] = {}
    for number, node in enumerate(nodes):
        if "camera" not in node:
            continue
        lens = data["cameras"][node["camera"]]
        name = str(node.get("name") or lens.get("name") or f"camera{node['camera']}")
        used[name] = used.get(name, 0) + 1
        world_from_node, at = _matrix(node), number
        for _ in nodes:  # as many steps as there are nodes end even where they form a ring
            if at not in above:
                break
            at = above[at]
            world_from_node = _matrix(nodes[at]) @ world_from_node
        yield name if used[name] == 1 else f"{name}.{used[name]}", _camera(lens, world_from_node)


def _matrix(node: dict) -> np.ndarray:
    """[4, 4] of a node within its parent."""
    if "matrix" in node:
        return np.asarray(node["matrix"], float).reshape(4, 4).T
    x, y, z, w = node.get("rotation", (0.0, 0.0, 0.0, 1.0))
    turn = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )
    matrix = np.eye(4)
    matrix[:3, :3] = turn * np.asarray(node.get("scale", (1.0, 1.0, 1.0)), float)
    matrix[:3, 3] = node.get("translation", (0.0, 0.0, 0.0))
    return matrix


def _camera(lens: dict, world_from_node: np.ndarray) -> Camera:
    eye, up, back = (world_from_node[:3, column] for column in (3, 1, 2))
    place = tuple(eye), tuple(eye - vector.normalise(back)), tuple(vector.normalise(up))
    if lens.get("type") == "orthographic":
        return Camera(*place, ortho=2.0 * float(lens["orthographic"]["ymag"]))
    return Camera(*place, fov_deg=float(np.clip(np.degrees(lens["perspective"]["yfov"]), 1.0, 170.0)))
