"""Read Wavefront OBJ files into arrays, strictly: every fault is named with its line.

Numbers of one kind of line are parsed together; only where that fails lines are looked at one by one, for the fault.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..errors import InputError
from .coincident import split_vertices
from .mtl import read_materials
from .polygons import triangulate
from .raw import Material, Names, RawMesh, check_counts
from .text import Lines, Words

LEAST = {"v": 3, "vt": 1, "vn": 3}  # numbers of a line


@dataclass(frozen=True, eq=False)
class _Corners:
    """The corners of all faces: v, vt, vn [3, C] from 0, -1 for one that is left out; the line of each face, its corners."""

    index: np.ndarray
    lines: np.ndarray
    counts: np.ndarray


def read_obj(blob: bytes, path: Path, colored: bool = False, grey: float | None = None) -> RawMesh:
    """Return the geometry of an OBJ file, its parts by material, group and object, and, if asked for, its materials.

    Parameters
    ----------
    blob : the file's bytes
    path : names it in messages, and is where its material files are looked for
    colored : read the material files
    grey : reflectance where the file names no material file; with it, materials that are missing or wrong are errors

    One vertex per distinct (v, vt, vn); polygons are cut into triangles. Lines other than v, vt, vn, f, g, o, usemtl and
    mtllib are skipped. Raises InputError, with the line, for a number that is none, a face of fewer than three corners,
    and an index that is zero or out of range.
    """
    where = str(path)
    lines = Lines(blob, where)
    kinds = {name: lines.that_begin(name) for name in ("v", "vt", "vn", "f")}
    check_counts(where, max(len(kinds[name]) for name in ("v", "vt", "vn")), len(kinds["f"]))
    values = {name: _values(lines, kinds[name], name) for name in LEAST}
    if not len(values["v"]):
        raise InputError(f"{where}: no vertices (lines `v x y z`), so it is no OBJ mesh; give another file")
    if not len(kinds["f"]):
        raise InputError(f"{where}: {len(values['v'])} vertices but no faces; export it with its faces (lines `f ...`)")
    faces = _faces(lines, kinds, where)
    cut, polygon = triangulate(values["v"][:, :3], faces.index[0], faces.counts)
    check_counts(where, triangles=len(cut))
    corner, source, first = split_vertices(faces.index[0], faces.index[1:].T, len(values["v"]))
    check_counts(where, len(source))

    def attribute(kind: str, column: int, width: int) -> np.ndarray | None:
        if not len(values[kind]) or (faces.index[column] < 0).all():
            return None
        # Row -1 is NaN: the vertices no face uses, and the corners that name no value.
        rows = np.vstack([values[kind][:, :width], np.full((1, width), np.nan)])
        return rows[np.where(first < 0, -1, faces.index[column, first])]

    states = _states(lines)
    state_of = (np.searchsorted([s.line for s in states], faces.lines) - 1)[polygon]
    parts, part_of = _numbered([s.part for s in states], state_of)
    names, material_of = _numbered([s.material for s in states], state_of)
    libraries = [name for _, kind, name in lines.named if kind == "mtllib"]
    materials = read_materials(path, names, libraries, grey) if colored else ()
    positions = values["v"]
    colors = None
    if colored and positions.shape[1] == 6 and np.isfinite(positions[:, 3:]).all() and not libraries:
        colors = _vertex_colors(positions[:, 3:])[faces.index[0]][cut].mean(1)
        materials = tuple(Material(name) for name in names)
    return RawMesh(
        np.ascontiguousarray(positions[source, :3]),
        corner[cut],
        attribute("vt", 1, 2),
        attribute("vn", 2, 3),
        tuple(parts),
        part_of,
        materials,
        material_of,
        colors,
    )


def _vertex_colors(rows: np.ndarray) -> np.ndarray:
    """Linear reflectances of what scanners write after x y z: sRGB, to 1 or to 255."""
    from ..color import srgb_decode

    return srgb_decode(np.clip(rows / (255.0 if rows.max(initial=0.0) > 1.0 else 1.0), 0.0, 1.0))


# Numbers ----------------------------------------------------------------------------------------------------------


def _values(lines: Lines, which: np.ndarray, kind: str) -> np.ndarray:
    """The numbers of the lines of a kind, [N, 3]; v with colours [N, 6]; a missing v of `vt u` is 0."""
    if not len(which):
        return np.zeros((0, 3))
    text = lines.joined(which, len(kind))
    count = text.words_per_line()
    if (count < LEAST[kind]).any():
        bad = which[np.argmax(count < LEAST[kind])]
        raise lines.fault(bad, f"expected {LEAST[kind]} numbers; is the file cut off?", whole=True)
    total = int(count.sum())
    numbers = text.floats()
    if len(numbers) != total:
        # Some word is no number: it may be one that nobody reads.
        width = 3
        numbers, count = _one_by_one(lines, which, kind), np.full(len(which), width)
    if (count == 3).all():
        return numbers.reshape(-1, 3)
    begin = np.cumsum(count) - count
    width = 6 if kind == "v" and (count >= 6).all() else 3
    rows = np.zeros((len(which), width))
    for k in range(width):
        there = count > k
        rows[there, k] = numbers[begin[there] + k]
    return rows


def _one_by_one(lines: Lines, which: np.ndarray, kind: str) -> np.ndarray:
    """The numbers of lines that hold other words, too; [3 N]. Raises InputError for the first that is no number."""
    rows = []
    for line in which.tolist():
        words = lines.words(line)[1:4]
        try:
            row = [float(word) for word in words]
        except ValueError:
            raise lines.fault(line, "expected numbers; mend or re-export it", whole=True) from None
        rows.append([*row, 0.0, 0.0][:3])
    return np.array(rows, float).ravel()


# Faces ------------------------------------------------------------------------------------------------------------


def _faces(lines: Lines, kinds: dict[str, np.ndarray], where: str) -> _Corners:
    which = kinds["f"]
    text = lines.joined(which, 1)
    counts = text.words_per_line()
    if (counts < 3).any():
        bad = int(np.argmax(counts < 3))
        raise lines.fault(which[bad], f"a face of {counts[bad]} corners, expected 3 or more; is the file cut off?")
    check_counts(where, triangles=int(counts.sum()) - 2 * len(counts))
    index = _corner_numbers(text, int(counts.sum()))
    if index is None:
        index = np.array(
            [_corner(lines, line, w) for line in which.tolist() for w in lines.words(line)[1:]], np.int64
        ).T.copy()
    line_of = np.repeat(which.astype(np.int32), counts)
    for column, kind in enumerate(("v", "vt", "vn")):
        given = index[column]
        back = given < 0
        if back.any():
            given[back] += 1 + np.searchsorted(kinds[kind], line_of[back])
        bad = (given < 1) & ((column == 0) | back | (given == ZERO)) | (given > len(kinds[kind]))
        if bad.any():
            corner = int(np.argmax(bad))
            line = int(line_of[corner])
            word = lines.words(line)[1 + corner - int(np.searchsorted(line_of, line))]
            said = [*word.split("/"), "", ""][column]
            raise lines.fault(
                line,
                f"face corner `{word}`: {kind} index {said} is out of range, {len(kinds[kind])} defined; "
                "re-export the file",
            )
        given -= 1
        given[given < 0] = -1
    return _Corners(index, which, counts)


ZERO = -(1 << 40)  # stands for an index of 0 that the file gives, which is wrong; 0 stands for none


def _corner_numbers(text: Words, total: int) -> np.ndarray | None:
    """v, vt, vn [3, C] of all words v, v/vt, v//vn and v/vt/vn, 0 for one left out; None where a word is none of these."""
    slashes, doubled, dangling = text.slashes()
    if dangling:
        return None
    numbers = text.integers()
    width = 1 + slashes - doubled
    if len(numbers) != int(width.sum()) or (slashes > 2).any() or (doubled & (slashes != 2)).any():
        return None
    numbers[numbers == 0] = ZERO
    if (width == width[0]).all():
        rows = numbers.reshape(total, -1)
        index = np.zeros((3, total), np.int64)
        index[0] = rows[:, 0]
        if rows.shape[1] > 1:
            index[2 if doubled[0] else 1] = rows[:, 1]
        if rows.shape[1] > 2:
            index[2] = rows[:, 2]
        return index if (doubled == doubled[0]).all() else None
    begin = np.cumsum(width) - width
    index = np.zeros((3, total), np.int64)
    index[0] = numbers[begin]
    with_uv = (slashes >= 1) & (doubled == 0)
    index[1, with_uv] = numbers[begin[with_uv] + 1]
    with_normal = slashes == 2
    index[2, with_normal] = numbers[begin[with_normal] + width[with_normal] - 1]
    return index


def _corner(lines: Lines, line: int, word: str) -> tuple[int, int, int]:
    """The numbers of one `v/vt/vn` word, 0 for a part left out."""
    found = [0, 0, 0]
    parts = word.split("/")
    if len(parts) > 3 or not parts[0]:
        raise lines.fault(line, f"face corner `{word}`, expected v, v/vt, v//vn or v/vt/vn; mend or re-export it")
    for slot, part in enumerate(parts):
        if not part:
            continue
        try:
            found[slot] = max(min(int(part), 1 << 40), -(1 << 40)) or ZERO
        except ValueError:
            raise lines.fault(line, f"face corner `{word}`: `{part}` is no whole number; re-export the file") from None
    return found[0], found[1], found[2]


# Names ------------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class _State:
    """What holds from a line on."""

    line: int
    part: Names
    material: str


def _states(lines: Lines) -> list[_State]:
    """The names that hold from each line with `o`, `g` or `usemtl` on; the first holds from before the first line."""
    named = {"usemtl": "", "g": "", "o": ""}
    states = [_State(-1, (), "")]
    for line, kind, name in lines.named:
        if kind in named:
            named[kind] = name
            part = tuple(dict.fromkeys(v for v in named.values() if v))
            states.append(_State(line, part, named["usemtl"]))
    return states


def _numbered(names: list, state_of: np.ndarray) -> tuple[list, np.ndarray]:
    """The distinct ones of the states' names that faces use, in the order of their first use, and their numbers [T]."""
    known = {name: i for i, name in enumerate(dict.fromkeys(names))}
    number = np.array([known[name] for name in names], np.int32)[state_of]
    used, first = np.unique(number, return_index=True)
    order = used[np.argsort(first)]
    new = np.zeros(len(known), np.int32)
    new[order] = np.arange(len(order))
    distinct = list(known)
    return [distinct[i] for i in order.tolist()], new[number]
