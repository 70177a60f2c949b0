"""Read Wavefront OBJ text into arrays, strictly: every fault is named with its line.

trimesh reads PLY and glTF here, but not OBJ: it resolves relative indices against the end of the file, drops the UVs
of a whole object when one index is wrong, and either reorders vertices or blends UVs where a seam splits a vertex
(`maintain_order`), which would bend the yarns along every seam.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..errors import InputError


@dataclass(frozen=True)
class ObjData:
    """Arrays of one OBJ file: one row per distinct (v, vt, vn) triple, polygons cut into fans of triangles.

    positions [V, 3] float64; uv [V, 2] float64 or None (NaN where a corner has none); normals [V, 3] float64 or None
    (NaN likewise); triangles [T, 3] int64; material [T] int32: index into materials, the `usemtl` names ("" = none).
    """

    positions: np.ndarray
    uv: np.ndarray | None
    normals: np.ndarray | None
    triangles: np.ndarray
    material: np.ndarray
    materials: tuple[str, ...]


def split_vertices(vertex: np.ndarray, key: np.ndarray, vertex_count: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Give each distinct (vertex, key) pair of the corners its own vertex, and keep the order of the old ones.

    vertex : [C] int; key : [C, n] int.  The first key met at a vertex keeps that vertex's number; further ones are
    appended in order of appearance.  Returns (corner [C] new vertex numbers, source [V'] old vertex of each new one,
    first [V'] the first corner that uses it, -1 when none does).
    """
    pairs = np.column_stack([vertex, key])
    _, begin, inverse = np.unique(pairs, axis=0, return_index=True, return_inverse=True)
    order = np.argsort(begin, kind="stable")
    owner = vertex[begin[order]]
    leads = np.zeros(len(order), bool)
    leads[np.unique(owner, return_index=True)[1]] = True
    number = np.where(leads, owner, 0)
    number[~leads] = vertex_count + np.arange(np.count_nonzero(~leads))
    of_pair = np.empty(len(order), np.int64)
    of_pair[order] = number
    source = np.concatenate([np.arange(vertex_count), owner[~leads]])
    first = np.full(len(source), -1, np.int64)
    first[number] = begin[order]
    return of_pair[inverse.reshape(-1)], source, first


def read_obj(text: str, where: str) -> ObjData:
    """Return the geometry of an OBJ file's text; `where` names the file in messages.

    Lines other than v, vt, vn, f and usemtl are skipped.  Raises InputError, with the line, for a number that is none,
    a face of fewer than three corners, and an index that is zero or out of range.
    """
    values: dict[str, list[list[float]]] = {"v": [], "vt": [], "vn": []}
    least = {"v": 3, "vt": 2, "vn": 3}
    corners: list[tuple[int, int, int]] = []
    material: list[int] = []
    materials: dict[str, int] = {}
    current = -1
    for number, line in enumerate(text.replace("\\\n", " ").splitlines(), 1):
        words = line.split("#", 1)[0].split()
        if not words:
            continue
        kind = words[0]
        if kind in values:
            values[kind].append(
                _numbers(words[1 : 1 + least[kind]], least[kind], f"{where}:{number}: `{line.strip()}`")
            )
        elif kind == "f":
            face = [_corner(word, values, f"{where}:{number}") for word in words[1:]]
            if len(face) < 3:
                raise InputError(
                    f"{where}:{number}: a face of {len(face)} corners, expected 3 or more; is the file cut off?"
                )
            if current < 0:
                current = materials.setdefault("", len(materials))
            for i in range(1, len(face) - 1):
                corners += (face[0], face[i], face[i + 1])
                material.append(current)
        elif kind == "usemtl":
            current = materials.setdefault(" ".join(words[1:]), len(materials))
    if not values["v"]:
        raise InputError(f"{where}: no vertices (lines `v x y z`), so it is no OBJ mesh; give another file")
    if not corners:
        raise InputError(f"{where}: {len(values['v'])} vertices but no faces; export it with its faces (lines `f ...`)")
    table = np.array(corners, np.int64)
    corner, source, first = split_vertices(table[:, 0], table[:, 1:], len(values["v"]))

    def attribute(kind: str, column: int) -> np.ndarray | None:
        if not values[kind] or (table[:, column] < 0).all():
            return None
        # Row -1 is NaN: the vertices no face uses, and the corners that name no value.
        rows = np.vstack([np.array(values[kind], float), np.full((1, least[kind]), np.nan)])
        return rows[np.where(first < 0, -1, table[first, column])]

    return ObjData(
        positions=np.array(values["v"], float)[source],
        uv=attribute("vt", 1),
        normals=attribute("vn", 2),
        triangles=corner.reshape(-1, 3),
        material=np.array(material, np.int32),
        materials=tuple(materials),
    )


def _numbers(words: list[str], count: int, where: str) -> list[float]:
    """Return the `count` numbers of a line."""
    try:
        row = [float(word) for word in words]
    except ValueError:
        raise InputError(f"{where}: expected numbers; mend or re-export it") from None
    if len(row) < count:
        raise InputError(f"{where}: expected {count} numbers; is the file cut off?")
    return row


def _corner(word: str, values: dict[str, list], where: str) -> tuple[int, int, int]:
    """Return zero-based (v, vt, vn) of one `v/vt/vn` word, -1 for a part left out; negative numbers count back."""
    found = [-1, -1, -1]
    parts = word.split("/")
    if len(parts) > 3 or not parts[0]:
        raise InputError(f"{where}: face corner `{word}`, expected v, v/vt, v//vn or v/vt/vn; mend or re-export it")
    for slot, (part, kind) in enumerate(zip(parts, ("v", "vt", "vn"), strict=False)):
        if not part:
            continue
        try:
            index = int(part)
        except ValueError:
            raise InputError(
                f"{where}: face corner `{word}`: `{part}` is no whole number; re-export the file"
            ) from None
        count = len(values[kind])
        zero_based = index - 1 if index > 0 else count + index
        if index == 0 or not 0 <= zero_based < count:
            raise InputError(
                f"{where}: face corner `{word}`: {kind} index {index} is out of range, {count} defined so far; "
                "re-export the file"
            )
        found[slot] = zero_based
    return found[0], found[1], found[2]


def read_mtl(text: str, where: str) -> dict[str, tuple[float, float, float]]:
    """Return {material: diffuse reflectance Kd} of an MTL file's text; a material without Kd is 70 % grey.

    Raises InputError, with the line, for a Kd that is not three numbers from 0 to 1.
    """
    colors: dict[str, tuple[float, float, float]] = {}
    name = None
    for number, line in enumerate(text.splitlines(), 1):
        words = line.split("#", 1)[0].split()
        if words[:1] == ["newmtl"]:
            name = " ".join(words[1:])
            colors[name] = (0.7, 0.7, 0.7)
        elif words[:1] == ["Kd"] and name is not None:
            try:
                color = tuple(float(word) for word in words[1:4])
            except ValueError:
                color = ()
            if len(color) != 3 or not all(0 <= c <= 1 for c in color):
                raise InputError(f"{where}:{number}: `{line.strip()}`: expected three numbers from 0 to 1; change it")
            colors[name] = color
    return colors


def read_obj_and_mtl(path: Path, grey: float) -> tuple[ObjData, np.ndarray]:
    """Return an OBJ file's geometry and the reflectances [M, 3] float32 (Kd, linear) of its materials; all of them are
    `grey` where it names no material file.

    Raises InputError for a file that cannot be read or is damaged, a material file that is missing and a material that
    it does not define.
    """
    try:
        text = path.read_text(encoding="utf-8", errors="replace")
        data = read_obj(text, str(path))
        named = [line.partition("mtllib ")[2].strip() for line in text.splitlines() if line.startswith("mtllib ")]
        libraries = [name for name in named if name]
        colors: dict[str, tuple[float, float, float]] = {}
        for name in libraries:
            library = path.parent / name
            if not library.is_file():
                raise InputError(f"{path}: names the material file {name}, which is not beside it; put it there")
            colors |= read_mtl(library.read_text(encoding="utf-8", errors="replace"), str(library))
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror}); check its permissions") from None
    missing = [name for name in data.materials if name and name not in colors] if libraries else []
    if missing:
        raise InputError(f"{path}: material `{missing[0]}` is not defined in {', '.join(libraries)}; define it there")
    return data, np.array([colors.get(name, (grey,) * 3) for name in data.materials], np.float32)
