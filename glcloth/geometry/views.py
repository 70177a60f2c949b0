"""Views by name: of any cloth by its size, and the cameras that a glTF file brings."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path

import numpy as np
from pyrr import vector

from ..errors import InputError, meant
from ..files import is_file, read_bytes
from .camera import Camera
from .gltf import BROKEN, Document
from .gltf_scene import node_matrix
from .raw import MOST_BYTES

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
    scale: float = 1.0,
) -> Camera:
    """The camera of a name: one of DIRECTIONS, or one of the file's.

    Parameters
    ----------
    points : [V, 3] of what it frames, metres
    aspect : width over height of the picture
    fov_deg, ortho : of the view, as for `Camera`; a file's camera has its own
    file : from which `points` were read
    scale : metres in a unit of the file, for its cameras

    Raises InputError for a name that neither has.
    """
    points = np.asarray(points, float)
    if name in DIRECTIONS:
        return (_close if name == "close" else _framing)(DIRECTIONS[name], points, aspect, fov_deg, ortho)
    path = Path(file) if file is not None else Path()
    known = file_cameras(path, path.stat().st_mtime_ns) if path.suffix.lower() in CAMERA_FILES and is_file(path) else {}
    if name == FILE and len(known) == 1:
        name = next(iter(known))
    if name not in known:
        names = [*DIRECTIONS, *known]
        has = f"{path} has {len(known)} cameras; " if path.suffix.lower() in CAMERA_FILES else ""
        raise InputError(f"camera: view {name!r}: unknown; {has}{meant(name, names)}expected {', '.join(names)}")
    return _toward(_scaled(known[name], scale), points)


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


def _scaled(camera: Camera, scale: float) -> Camera:
    """A camera of a file in another unit."""
    eye, target = (tuple(scale * np.asarray(point)) for point in (camera.eye, camera.target))
    return Camera(eye, target, camera.up, camera.fov_deg, None if camera.ortho is None else scale * camera.ortho)


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
    document = Document(read_bytes(path, MOST_BYTES), path)
    try:
        return dict(_cameras(document.json))
    except BROKEN:
        raise InputError(f"{path}: its cameras cannot be read; export it again, or give --eye and --target") from None


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
        world_from_node, at = node_matrix(node), number
        for _ in nodes:  # as many steps as there are nodes end even where they form a ring
            if at not in above:
                break
            at = above[at]
            world_from_node = node_matrix(nodes[at]) @ world_from_node
        yield name if used[name] == 1 else f"{name}.{used[name]}", _camera(lens, world_from_node)


def _camera(lens: dict, world_from_node: np.ndarray) -> Camera:
    eye, up, back = (world_from_node[:3, column] for column in (3, 1, 2))
    place = tuple(eye), tuple(eye - vector.normalise(back)), tuple(vector.normalise(up))
    if lens.get("type") == "orthographic":
        return Camera(*place, ortho=2.0 * float(lens["orthographic"]["ymag"]))
    return Camera(*place, fov_deg=float(np.clip(np.degrees(lens["perspective"]["yfov"]), 1.0, 170.0)))
