"""What a mesh file holds, before anything is mended: the value that every reader returns. And the limits of all of them."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from ..errors import InputError

MOST_TRIANGLES = 3 << 20  # about 1.5 GB while they are read
MOST_VERTICES = 3 << 20
MOST_BYTES = 1 << 29  # of a file, and of all that it names

Names = tuple[str, ...]  # of one part: material, group, object, as far as the file has them


@dataclass(frozen=True, eq=False)
class Material:
    """How an object looks in a plain physically based way.

    Parameters
    ----------
    name : "" where the file gives none
    color : linear Rec. 709; it multiplies the texture
    roughness, metalness : 0 to 1, as in glTF
    texture : a picture of base colours in sRGB, its file or its encoded bytes
    """

    name: str = ""
    color: tuple[float, float, float] = (1.0, 1.0, 1.0)
    roughness: float = 1.0
    metalness: float = 0.0
    texture: Path | bytes | None = None


@dataclass(frozen=True, eq=False)
class RawMesh:
    """Arrays of one file as they stand in it; NaN in a row of uv or normals says that it has none.

    Parameters
    ----------
    positions : [V, 3] float64
    triangles : [T, 3] int64
    uv : [V, 2] float64 or None
    normals : [V, 3] float64 or None
    parts, part_of : names of each part, and the part [T] of each triangle
    materials, material_of : of each triangle [T]
    colors : [T, 3] linear Rec. 709, which multiply the materials' colours, or None
    """

    positions: np.ndarray
    triangles: np.ndarray
    uv: np.ndarray | None = None
    normals: np.ndarray | None = None
    parts: tuple[Names, ...] = ((),)
    part_of: np.ndarray | None = None
    materials: tuple[Material, ...] = field(default=())
    material_of: np.ndarray | None = None
    colors: np.ndarray | None = None


def check_counts(where: str, vertices: int = 0, triangles: int = 0) -> None:
    """Raise InputError for more than there may be; readers ask before they make arrays of such lengths."""
    for what, count, most in (("vertices", vertices, MOST_VERTICES), ("triangles", triangles, MOST_TRIANGLES)):
        if count > most:
            raise InputError(f"{where}: {count:,} {what}, at most {most:,} can be read; reduce the mesh")


def joined(pieces: list[RawMesh], where: str) -> RawMesh:
    """Several pieces as one, in their order."""
    if not pieces:
        raise InputError(f"{where}: holds no triangles; export it with its faces")
    if len(pieces) == 1:
        return pieces[0]
    check_counts(where, sum(len(p.positions) for p in pieces), sum(len(p.triangles) for p in pieces))
    begins = np.cumsum([0] + [len(p.positions) for p in pieces])
    parts = list(dict.fromkeys(name for p in pieces for name in p.parts))
    materials = list(dict.fromkeys(material for p in pieces for material in p.materials))

    def column(name: str, width: int, of: str = "positions", default: float = np.nan) -> np.ndarray | None:
        if all(getattr(p, name) is None for p in pieces):
            return None
        rows = [(getattr(p, name), len(getattr(p, of))) for p in pieces]
        return np.concatenate([np.full((count, width), default) if v is None else v for v, count in rows])

    def numbers(of: str, names: str, known: list) -> np.ndarray:
        rows = []
        for p in pieces:
            number = np.array([known.index(name) for name in getattr(p, names)] or [0], np.int32)
            index = getattr(p, of)
            rows.append(number[np.zeros(len(p.triangles), int) if index is None else index])
        return np.concatenate(rows)

    return RawMesh(
        np.concatenate([p.positions for p in pieces]),
        np.concatenate([p.triangles + begin for p, begin in zip(pieces, begins, strict=False)]),
        column("uv", 2),
        column("normals", 3),
        tuple(parts),
        numbers("part_of", "parts", parts),
        tuple(materials),
        numbers("material_of", "materials", materials) if materials else None,
        column("colors", 3, "triangles", 1.0),
    )
