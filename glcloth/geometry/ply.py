"""Read Stanford PLY files: polygons or strips of triangles, with UVs of vertices or of corners, and colours."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ..color import srgb_decode
from ..errors import InputError
from .coincident import split_vertices
from .polygons import triangulate
from .raw import MOST_TRIANGLES, RawMesh, check_counts
from .text import parsed

KINDS = {"char": "i1", "int8": "i1", "uchar": "u1", "uint8": "u1", "short": "i2", "int16": "i2", "ushort": "u2",
         "uint16": "u2", "int": "i4", "int32": "i4", "uint": "u4", "uint32": "u4", "float": "f4", "float32": "f4",
         "double": "f8", "float64": "f8"}  # fmt: skip
FORMATS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
UV_NAMES = (("s", "t"), ("u", "v"), ("texture_u", "texture_v"), ("texcoord_u", "texcoord_v"))
MOST_HEADER = 1 << 16


@dataclass(frozen=True)
class _Property:
    name: str
    kind: str
    count: str = ""  # the kind of a list's length; "" for one number


@dataclass(frozen=True)
class _Element:
    name: str
    count: int
    properties: tuple[_Property, ...]


Lists = tuple[np.ndarray, np.ndarray]  # the numbers of all lists, and the length of each
Table = dict[str, "np.ndarray | Lists"]


def read_ply(blob: bytes, where: str) -> RawMesh:
    """Return the mesh of a PLY file's bytes. Raises InputError for a file that is damaged, cut off or too large."""
    elements, order, body = _header(blob, where)
    check_counts(where, *(next((e.count for e in elements if e.name == name), 0) for name in ("vertex", "face")))
    try:
        tables = _ascii(body, elements) if not order else _binary(body, elements, order)
        return _mesh(tables, where)
    except InputError:
        raise
    except (ValueError, IndexError, KeyError, TypeError, OverflowError, MemoryError) as error:
        reason = " ".join(str(error).split())[:100] or type(error).__name__
        raise InputError(f"{where}: cannot be read as ply ({reason}); is it whole? export it again") from None


def _header(blob: bytes, where: str) -> tuple[list[_Element], str, bytes]:
    """The elements, the order of bytes ("" for text), and what follows."""
    bad = f"{where}: cannot be read as ply"
    end = blob.find(b"end_header", 0, MOST_HEADER)
    if not blob.startswith(b"ply") or end < 0:
        raise InputError(f"{bad} (no header of a PLY file); export it again")
    after = blob.find(b"\n", end)
    if blob[end + 10 : end + 11] == b"\r" and blob[end + 11 : end + 12] != b"\n":
        after = end + 10
    body = blob[after + 1 :] if after >= 0 else b""
    order = None
    elements: list[_Element] = []
    for line in blob[:end].replace(b"\r", b"\n").decode("latin-1").split("\n"):
        words = line.split()
        try:
            if words[:1] == ["format"]:
                order = FORMATS[words[1]]
            elif words[:1] == ["element"]:
                elements.append(_Element(words[1], int(words[2]), ()))
            elif words[:1] == ["property"]:
                last = elements[-1]
                new = _Property(words[-1], KINDS[words[-2]], KINDS[words[2]] if words[1] == "list" else "")
                elements[-1] = _Element(last.name, last.count, (*last.properties, new))
        except (KeyError, IndexError, ValueError):
            raise InputError(f"{bad} (its header says `{line.strip()[:60]}`); export it again") from None
    if order is None or any(element.count < 0 for element in elements):
        raise InputError(f"{bad} (its header says no format, or a negative count); export it again")
    return elements, order, body


# Bodies -----------------------------------------------------------------------------------------------------------


def _ascii(body: bytes, elements: list[_Element]) -> dict[str, Table]:
    """The tables of a text body."""
    least = sum(element.count * max(len(element.properties), 1) for element in elements)
    if least > len(body):
        raise ValueError(f"{len(body)} bytes, too few for what the header says")
    numbers = parsed(body, np.float64)
    if not len(numbers) and least:
        raise ValueError("a word is no number")
    tables: dict[str, Table] = {}
    at = 0
    for element in elements:
        widths = len(element.properties)
        if not any(p.count for p in element.properties):
            rows = numbers[at : at + element.count * widths].reshape(element.count, widths)
            at += element.count * widths
            tables[element.name] = {p.name: rows[:, k] for k, p in enumerate(element.properties)}
            continue
        begins, at = _row_begins(numbers, at, element)
        if at > len(numbers):
            raise ValueError("cut off")
        tables[element.name] = {p.name: _lists(numbers, b, p) for p, b in zip(element.properties, begins, strict=True)}
    return tables


def _row_begins(numbers: np.ndarray, at: int, element: _Element) -> tuple[list[np.ndarray], int]:
    """Where each property of each row of a text body begins, and where the rows end."""
    first: list[int] = []
    end = at
    for p in element.properties if element.count else ():
        first.append(end)
        end += 1 + (_length(numbers[end]) if p.count else 0)
    step = end - at
    if at + step * element.count <= len(numbers):
        begins = [b + step * np.arange(element.count) for b in first]
        lists = [b for b, p in zip(begins, element.properties, strict=False) if p.count]
        if all((numbers[b] == numbers[b[0]]).all() for b in lists if len(b)):
            return begins or [np.zeros(0, int)] * len(element.properties), at + step * element.count
    rows: list[list[int]] = [[] for _ in element.properties]
    for _ in range(element.count):
        for row, p in zip(rows, element.properties, strict=True):
            row.append(at)
            at += 1 + (_length(numbers[at]) if p.count else 0)
    return [np.array(row, int) for row in rows], at


def _length(number: float) -> int:
    if not 0 <= number <= MOST_TRIANGLES * 3 or number != int(number):
        raise ValueError(f"a list of {number:g} numbers")
    return int(number)


def _lists(numbers: np.ndarray, begins: np.ndarray, p: _Property) -> np.ndarray | Lists:
    """The values of one property whose rows begin at these places of a body of numbers."""
    if not p.count:
        return numbers[begins]
    counts = numbers[begins].astype(np.int64)
    return numbers[_ranges(begins + 1, counts)], counts


def _ranges(begins: np.ndarray, counts: np.ndarray) -> np.ndarray:
    """begin, begin + 1, ... of each, `counts` of them, one after the other."""
    total = int(counts.sum())
    first = np.repeat(begins - (np.cumsum(counts) - counts), counts)
    return first + np.arange(total)


def _binary(body: bytes, elements: list[_Element], order: str) -> dict[str, Table]:
    """The tables of a binary body."""
    tables: dict[str, Table] = {}
    at = 0
    for element in elements:
        if not any(p.count for p in element.properties):
            row = np.dtype([(f"{k}", order + p.kind) for k, p in enumerate(element.properties)])
            size = row.itemsize * element.count
            if at + size > len(body):
                raise ValueError("cut off")
            rows = np.frombuffer(body, row, element.count, at) if row.itemsize else np.zeros(element.count, row)
            tables[element.name] = {p.name: rows[f"{k}"] for k, p in enumerate(element.properties)}
            at += size
            continue
        tables[element.name], at = _binary_lists(body, at, element, order)
    return tables


def _binary_lists(body: bytes, at: int, element: _Element, order: str) -> tuple[Table, int]:
    """The table of an element with lists: at once if all rows are as long as the first, else row by row."""
    if element.count == 0:
        return {
            p.name: (np.zeros(0), np.zeros(0, np.int64)) if p.count else np.zeros(0) for p in element.properties
        }, at
    lengths, end = _row(body, at, element, order)
    if (end - at) * element.count <= len(body) - at:
        fields = []
        for k, (p, length) in enumerate(zip(element.properties, lengths, strict=True)):
            fields += [(f"n{k}", order + p.count)] if p.count else []
            fields += [(f"v{k}", order + p.kind, (length,) if p.count else ())]
        rows = np.frombuffer(body, np.dtype(fields), element.count, at)
        lists = [(k, p) for k, p in enumerate(element.properties) if p.count]
        if all((rows[f"n{k}"] == lengths[k]).all() for k, _ in lists):
            table: Table = {
                p.name: (rows[f"v{k}"].ravel(), np.full(element.count, lengths[k])) if p.count else rows[f"v{k}"]
                for k, p in enumerate(element.properties)
            }
            return table, at + (end - at) * element.count
    return _row_by_row(body, at, element, order)


def _row(body: bytes, at: int, element: _Element, order: str) -> tuple[list[int], int]:
    """The lengths of the lists of a row (0: one number), and where it ends."""
    lengths = []
    for p in element.properties:
        length = 0
        if p.count:
            kind = np.dtype(order + p.count)
            length = _length(float(np.frombuffer(body, kind, 1, at)[0]))
            at += kind.itemsize
        at += np.dtype(p.kind).itemsize * (length if p.count else 1)
        lengths.append(length)
    if at > len(body):
        raise ValueError("cut off")
    return lengths, at


def _row_by_row(body: bytes, at: int, element: _Element, order: str) -> tuple[Table, int]:
    """The table of an element whose lists differ in length."""
    sizes = [(np.dtype(p.count).itemsize if p.count else 0, np.dtype(p.kind).itemsize) for p in element.properties]
    big = "big" if order == ">" else "little"
    if any(p.count and p.count[0] == "f" for p in element.properties):
        raise ValueError("the length of a list is no whole number")
    begins: list[list[int]] = [[] for _ in sizes]
    counts: list[list[int]] = [[] for _ in sizes]
    end = len(body)
    for _ in range(element.count):
        for k, (head, size) in enumerate(sizes):
            length = int.from_bytes(body[at : at + head], big) if head else 1
            at += head
            begins[k].append(at)
            counts[k].append(length)
            at += size * length
        if at > end:
            raise ValueError("cut off")
    table: Table = {}
    data = np.frombuffer(body, np.uint8)
    for k, p in enumerate(element.properties):
        count, size = np.array(counts[k], np.int64), sizes[k][1]
        places = _ranges(np.array(begins[k], np.int64), count * size)
        values = data[places].tobytes()
        numbers = np.frombuffer(values, order + p.kind)
        table[p.name] = (numbers, count) if p.count else numbers
    return table, at


# What they mean ---------------------------------------------------------------------------------------------------


def _mesh(tables: dict[str, Table], where: str) -> RawMesh:
    vertex = tables.get("vertex")
    if not vertex or not all(_is_numbers(vertex.get(axis)) for axis in "xyz"):
        raise InputError(f"{where}: holds no vertices with x, y, z; export it with its faces")
    positions = _columns(vertex, ("x", "y", "z"))
    normals = _columns(vertex, ("nx", "ny", "nz"))
    uv = next((found for names in UV_NAMES if (found := _columns(vertex, names)) is not None), None)
    face = tables.get("face", {})
    polygons = next((v for name in ("vertex_indices", "vertex_index") if isinstance(v := face.get(name), tuple)), None)
    if polygons is None or not len(polygons[1]):
        strips = tables.get("tristrips", {}).get("vertex_indices")
        if not isinstance(strips, tuple):
            raise InputError(f"{where}: holds no triangles; export it with its faces")
        triangles = _from_strips(strips)
        check_counts(where, triangles=len(triangles))
        return RawMesh(positions, triangles, uv, normals, colors=_colors(vertex, triangles))
    corners, counts = polygons[0].astype(np.int64), polygons[1]
    if len(corners) and (corners.min() < 0 or corners.max() >= len(positions)):
        worst = corners.min() if corners.min() < 0 else corners.max()
        raise InputError(
            f"{where}: a face names vertex {worst}, out of range, it has {len(positions)}; export it again"
        )
    wide = counts >= 3
    corner_uv = face.get("texcoord")
    own_uv = isinstance(corner_uv, tuple) and len(corner_uv[0]) == 2 * len(corners) and uv is None
    if not wide.all():
        keep = np.repeat(wide, counts)
        corner_uv = (corner_uv[0].reshape(-1, 2)[keep].ravel(), None) if own_uv else None
        corners, counts = corners[keep], counts[wide]
    if not len(counts):
        raise InputError(f"{where}: holds no triangles; export it with its faces")
    check_counts(where, triangles=int(counts.sum()) - 2 * len(counts))
    cut, polygon = triangulate(positions, corners, counts)
    triangles = corners[cut]
    colors = _face_colors(face, np.flatnonzero(wide)[polygon])
    colors = _colors(vertex, triangles) if colors is None else colors
    if own_uv:
        rows = np.asarray(corner_uv[0], np.float64).reshape(-1, 2)
        corner, source, first = split_vertices(corners, rows.view(np.int64), len(positions))
        rows = np.vstack([rows, [[np.nan, np.nan]]])
        normals = None if normals is None else normals[source]
        return RawMesh(positions[source], corner[cut], rows[first], normals, colors=colors)
    return RawMesh(positions, triangles, uv, normals, colors=colors)


def _is_numbers(value) -> bool:
    return isinstance(value, np.ndarray)


def _columns(table: Table, names: tuple[str, ...]) -> np.ndarray | None:
    if not all(_is_numbers(table.get(name)) for name in names):
        return None
    with np.errstate(invalid="ignore"):  # damaged floats may be signalling NaNs
        return np.column_stack([np.asarray(table[name], np.float64) for name in names])


def _rgb(table: Table) -> np.ndarray | None:
    """Linear colours of rows: sRGB in whole numbers to 255, or to 65535, or floats to 1."""
    columns = [table.get(name) for name in ("red", "green", "blue")]
    if not all(_is_numbers(column) for column in columns):
        return None
    rows = np.column_stack(columns).astype(np.float64)
    kind = columns[0].dtype
    whole = 65535.0 if kind == np.dtype("u2") or (kind.kind != "u" and rows.max(initial=0.0) > 255) else 255.0
    return srgb_decode(np.clip(rows / (whole if kind.kind in "iu" or rows.max(initial=0.0) > 1.0 else 1.0), 0.0, 1.0))


def _colors(vertex: Table, triangles: np.ndarray) -> np.ndarray | None:
    rows = _rgb(vertex)
    return None if rows is None else rows[np.clip(triangles, 0, len(rows) - 1)].mean(1)


def _face_colors(face: Table, polygon: np.ndarray) -> np.ndarray | None:
    rows = _rgb(face)
    return None if rows is None else rows[polygon]


def _from_strips(strips: Lists) -> np.ndarray:
    """The triangles of strips, which -1 ends."""
    numbers, counts = strips[0].astype(np.int64), strips[1]
    ends = np.cumsum(counts)
    found = [np.zeros((0, 3), np.int64)]
    for begin, end in zip((ends - counts).tolist(), ends.tolist(), strict=True):
        found += list(_of_strip(numbers[begin:end]))
    return np.concatenate(found)


def _of_strip(strip: np.ndarray) -> Iterator[np.ndarray]:
    for piece in np.split(strip, np.flatnonzero(strip < 0)):
        piece = piece[piece >= 0]
        i = np.arange(max(len(piece) - 2, 0))
        yield (
            np.stack([piece[i], piece[i + 1 + i % 2], piece[i + 2 - i % 2]], 1)
            if len(i)
            else np.zeros((0, 3), np.int64)
        )
