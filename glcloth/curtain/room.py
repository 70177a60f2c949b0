"""The built-in room: walls, a window with its frame, a curtain rod, some furniture; 146 triangles.

With the default curtain that makes the 12,786 triangles of paper B's scene. `python -m glcloth.curtain.room` writes
scenes/room.obj and scenes/room.mtl anew; `load_room` reads these or any other OBJ with its MTL. Metres, +Y up, the
window in the plane z = 0 with the room before it (z > 0).
"""

from __future__ import annotations

import itertools
import sys
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ..errors import InputError
from ..files import PACKAGE, atomic_write, read_bytes
from ..geometry.obj import read_obj
from ..geometry.raw import MOST_BYTES
from .curtains import panels_of
from .hanging import CurtainParameters, pleated_rail

ROOM = PACKAGE / "scenes" / "room.obj"
# Diffuse reflectances, linear Rec. 709.
MATERIALS = {
    "plaster": (0.76, 0.73, 0.67),
    "ceiling": (0.82, 0.82, 0.80),
    "floor": (0.40, 0.26, 0.15),
    "frame": (0.78, 0.77, 0.74),
    "metal": (0.32, 0.31, 0.30),
    "table": (0.28, 0.15, 0.08),
    "rug": (0.45, 0.12, 0.10),
    "picture": (0.12, 0.22, 0.34),
}
LOW, HIGH = (-2.0, 0.0, 0.0), (2.0, 2.7, 4.0)  # the room
WINDOW_LOW, WINDOW_HIGH = (-1.1, 0.4), (1.1, 2.35)  # x, y of its opening
REVEAL = 0.14  # m, thickness of the wall
FACES = {"-x": (0, 0), "+x": (0, 1), "-y": (1, 0), "+y": (1, 1), "-z": (2, 0), "+z": (2, 1)}


@dataclass(frozen=True)
class Room:
    """A room as triangles: positions [T, 3, 3] float32, m; material [T] int32 indexes reflectances [M, 3] float32
    (linear Rec. 709), whose names are `names`."""

    positions: np.ndarray
    material: np.ndarray
    reflectances: np.ndarray
    names: tuple[str, ...]


def load_room(path: str | Path = ROOM) -> Room:
    """Read an OBJ whose MTL gives the reflectances (Kd); without one everything is 70 % grey.

    Raises InputError for files that are missing or damaged, and for materials that the MTL does not define.
    """
    path = Path(path)
    if not path.is_file():
        what = "is a folder, a pipe or a device" if path.exists() else "no such file"
        raise InputError(f"{path}: {what}; check the path, or leave it out for the built-in room")
    data = read_obj(read_bytes(path, MOST_BYTES), path, colored=True, grey=0.7)
    positions = data.positions[data.triangles]
    if not np.isfinite(positions.astype(np.float32)).all():
        raise InputError(f"{path}: a vertex is not finite; mend the file")
    reflectances = np.array([material.color for material in data.materials], np.float32)
    names = tuple(material.name for material in data.materials)
    return Room(positions.astype(np.float32), data.material_of, reflectances, names)


def with_rod(room: Room, parameters: CurtainParameters) -> Room:
    """The built-in room with a rod as long as the rail, and a second one where there are two curtains. Raises InputError where
    the walls are nearer."""
    width = parameters.width
    if parameters.behind:
        room = _with_second_rod(room, parameters)
    if width == CurtainParameters().width:
        return room
    if width > HIGH[0] - LOW[0] - 0.2:
        raise InputError(
            f"curtain: width = {width:g} m: the walls of the built-in room are {HIGH[0] - LOW[0]:g} m apart, expected at most "
            f"{HIGH[0] - LOW[0] - 0.2:g}; make it narrower, or give a room of your own"
        )
    positions = room.positions.copy()
    rod = room.material == room.names.index("metal")
    positions[rod, :, 0] = np.sign(positions[rod, :, 0]) * np.float32(width / 2 + 0.08)
    return replace(room, positions=positions)


def _with_second_rod(room: Room, parameters: CurtainParameters) -> Room:
    """The rod of the front curtain is as the other one, as much further from the window as the folds are."""
    front, *_, behind = panels_of(parameters)
    z = [pleated_rail(panel.parameters, panel.parameters.quads[0] + 1)[:, 1] for panel in (front, behind)]
    apart = np.float32((z[0].min() + z[0].max() - z[1].min() - z[1].max()) / 2)
    rod = np.flatnonzero(room.material == room.names.index("metal"))
    positions = np.concatenate([room.positions, room.positions[rod] + np.float32([0.0, 0.0, apart])])
    return replace(room, positions=positions, material=np.concatenate([room.material, room.material[rod]]))


Quad = tuple[str, np.ndarray]  # material, corners [4, 3] counter-clockwise seen from the side that faces the room


def box(material: str, low, high, without: str = "") -> list[Quad]:
    """Return the faces of a box, outside in front, but for those named in `without`, such as "-y +z"."""
    corner = np.array([low, high], float)
    quads = []
    for name, (axis, side) in FACES.items():
        if name in without.split():
            continue
        u, v = (axis + 1) % 3, (axis + 2) % 3
        face = np.empty((4, 3))
        face[:, axis] = corner[side, axis]
        face[:, u], face[:, v] = corner[[0, 1, 1, 0], u], corner[[0, 0, 1, 1], v]
        quads.append((material, face if side else face[::-1]))
    return quads


def inside_out(quads: list[Quad]) -> list[Quad]:
    """Return faces that are seen from the other side."""
    return [(material, corners[::-1]) for material, corners in quads]


def prism(material: str, center, radius: float, half_length: float, sides: int) -> list[Quad]:
    """Return the sides of a prism along x, without its ends."""
    angle = 2 * np.pi * np.arange(sides + 1) / sides
    rim = np.column_stack([np.zeros(sides + 1), radius * np.cos(angle), radius * np.sin(angle)]) + center
    across = np.array([half_length, 0.0, 0.0])
    return [(material, np.array([a - across, b - across, b + across, a + across])) for a, b in itertools.pairwise(rim)]


def furnish() -> list[Quad]:
    """Return the quads of the built-in room."""
    (x_0, y_0), (x_1, y_1) = WINDOW_LOW, WINDOW_HIGH
    quads = inside_out(box("plaster", LOW, HIGH, without="-y +y -z"))
    quads += inside_out(box("floor", LOW, HIGH, without="-x +x +y -z +z"))
    quads += inside_out(box("ceiling", LOW, HIGH, without="-x +x -y -z +z"))
    # The window's wall, round the opening, and the faces of the opening in the thickness of the wall.
    for low, high in (
        ((LOW[0], LOW[1]), (x_0, HIGH[1])),
        ((x_1, LOW[1]), (HIGH[0], HIGH[1])),
        ((x_0, LOW[1]), (x_1, y_0)),
        ((x_0, y_1), (x_1, HIGH[1])),
    ):
        quads += inside_out(box("plaster", (*low, 0.0), (*high, 1.0), without="-x +x -y +y +z"))
    quads += inside_out(box("plaster", (x_0, y_0, -REVEAL), (x_1, y_1, 0.0), without="-z +z"))
    # Frame, mullion and transom are bars whose ends are hidden.
    bar, back, front = 0.06, -0.11, -0.05
    for x in (x_0, x_1 - bar):
        quads += box("frame", (x, y_0, back), (x + bar, y_1, front), without="-y +y")
    for y in (y_0, y_1 - bar):
        quads += box("frame", (x_0 + bar, y, back), (x_1 - bar, y + bar, front), without="-x +x")
    quads += box("frame", (-bar / 2, y_0 + bar, back), (bar / 2, y_1 - bar, front), without="-y +y")
    quads += box("frame", (x_0 + bar, 1.7, back), (x_1 - bar, 1.7 + bar, front), without="-x +x")
    quads += box("frame", (x_0 - 0.08, y_0 - 0.03, 0.0), (x_1 + 0.08, y_0, 0.04), without="-z")
    # The rod stands in the middle of the pleats, just above them.
    curtain = CurtainParameters()
    z = pleated_rail(curtain, curtain.quads[0] + 1)[:, 1]
    rod = (0.0, curtain.top + 0.025, (z.min() + z.max()) / 2)
    quads += prism("metal", rod, 0.018, curtain.width / 2 + 0.08, 6)
    # A small table on four legs by the window, a rug, a picture in its frame on the wall.
    low, high, top, leg = (-1.5, 0.8), (-0.8, 1.4), 0.55, 0.04
    quads += box("table", (low[0], top - 0.04, low[1]), (high[0], top, high[1]))
    for x in (low[0] + 0.03, high[0] - 0.03 - leg):
        for depth in (low[1] + 0.03, high[1] - 0.03 - leg):
            quads += box("table", (x, 0.0, depth), (x + leg, top - 0.04, depth + leg), without="-y +y")
    quads += box("rug", (-0.5, 0.0, 0.9), (1.5, 0.012, 2.6), without="-x +x -y -z +z")
    for material, margin, depth in (("table", 0.06, 0.012), ("picture", 0.0, 0.014)):
        corners = (LOW[0], 1.15 - margin, 1.3 - margin), (LOW[0] + depth, 1.85 + margin, 2.4 + margin)
        quads += box(material, *corners, without="-x -y +y -z +z")
    return quads


def room_text() -> tuple[str, str]:
    """Return the built-in room as (OBJ, MTL) text."""
    obj = [
        "# The room of the curtain scene, made by `python -m glcloth.curtain.room`; metres, +Y up.",
        "mtllib room.mtl",
    ]
    current, count, directions = None, 0, []
    for material, corners in furnish():
        if material != current:
            obj.append(f"usemtl {material}")
            current = material
        across = np.cross(corners[1] - corners[0], corners[3] - corners[0])
        normal = tuple(np.round(across / np.linalg.norm(across), 6) + 0.0)
        obj += [f"v {x:.6g} {y:.6g} {z:.6g}" for x, y, z in corners]
        if normal not in directions:
            directions.append(normal)
            obj.append("vn {:.6g} {:.6g} {:.6g}".format(*normal))
        n = directions.index(normal) + 1
        obj.append("f " + " ".join(f"{count + k}//{n}" for k in (1, 2, 3, 4)))
        count += 4
    mtl = ["# Reflectances are linear Rec. 709."]
    for name, color in MATERIALS.items():
        mtl += [f"newmtl {name}", "Kd {:g} {:g} {:g}".format(*color)]
    return "\n".join([*obj, ""]), "\n".join([*mtl, ""])


def save_room(path: str | Path = ROOM) -> None:
    """Write the built-in room to an OBJ and the MTL beside it. Raises InputError where they cannot be written."""
    obj, mtl = room_text()
    library = Path(path).with_suffix(".mtl")
    with atomic_write(library) as temporary:
        temporary.write_text(mtl, encoding="utf-8")
    with atomic_write(path) as temporary:
        temporary.write_text(obj.replace("mtllib room.mtl", f"mtllib {library.name}"), encoding="utf-8")


if __name__ == "__main__":
    save_room(*sys.argv[1:2])
