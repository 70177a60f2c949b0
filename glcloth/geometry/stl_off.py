"""Read STL (binary or text) and OFF files: triangles or polygons and nothing else."""

from __future__ import annotations

import re

import numpy as np

from ..errors import InputError
from .coincident import distinct
from .polygons import triangulate
from .raw import RawMesh, check_counts
from .text import parsed, plain

RECORD = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
VERTEX = re.compile(rb"^[ \t]*vertex[ \t]+", re.MULTILINE | re.IGNORECASE)
SOLID = re.compile(rb"^[ \t]*(?:solid\b[ \t]*([^\n]*)|endfacet\b)", re.MULTILINE | re.IGNORECASE)
OFF_KIND = re.compile(rb"\s*(ST)?(C)?(N)?(4)?(n)?OFF\b")


def read_stl(blob: bytes, where: str) -> RawMesh:
    """Return an STL file's triangles; corners at one place are one vertex, and facets' normals are left out: the winding
    says the same. Raises InputError for a file that is damaged or too large."""
    count = int.from_bytes(blob[80:84], "little")
    if len(blob) >= 84 and len(blob) >= 84 + RECORD.itemsize * count and (count or not blob.startswith(b"solid")):
        check_counts(where, triangles=count)
        corners = np.frombuffer(blob, RECORD, count, 84)["corners"].astype(np.float64).reshape(-1, 3)
        return _welded(corners, where, ((),), np.zeros(count, np.int32))
    text = plain(blob)
    if not text.lstrip()[:5].lower().startswith(b"solid"):
        raise InputError(f"{where}: cannot be read as stl ({len(blob)} bytes for {count} triangles); export it again")
    pieces = VERTEX.split(text)[1:]
    check_counts(where, triangles=len(pieces) // 3)
    numbers = parsed(b"\n".join(piece.split(b"\n", 1)[0] for piece in pieces), np.float64)
    if not pieces or len(pieces) % 3 or len(numbers) != 3 * len(pieces):
        raise InputError(f"{where}: cannot be read as stl (it has no whole triangles); export it again")
    parts, part_of = _solids(text, len(pieces) // 3)
    return _welded(numbers.reshape(-1, 3), where, parts, part_of)


def _solids(text: bytes, count: int) -> tuple[tuple, np.ndarray]:
    """The names of the solids of a text STL, and which one each triangle belongs to."""
    names, part_of, number = [], [], -1
    for match in SOLID.finditer(text):
        if match[1] is not None:
            name = match[1].decode("utf-8", errors="replace").strip()
            names.append((name,) if name else ())
            number += 1
        else:
            part_of.append(max(number, 0))
    if len(part_of) != count:
        return ((),), np.zeros(count, np.int32)
    return tuple(names), np.array(part_of, np.int32)


def _welded(corners: np.ndarray, where: str, parts: tuple, part_of: np.ndarray) -> RawMesh:
    if not len(corners):
        raise InputError(f"{where}: holds no triangles; export it with its faces")
    first, group = distinct(corners)
    order = np.argsort(first)
    number = np.empty(len(order), np.int64)
    number[order] = np.arange(len(order))
    return RawMesh(corners[first[order]], number[group].reshape(-1, 3), parts=parts, part_of=part_of)


def read_off(blob: bytes, where: str) -> RawMesh:
    """Return an OFF file's polygons as triangles; colours are left out. Raises InputError as `read_stl`."""
    text = re.sub(rb"#[^\n]*", b"", plain(blob))
    head = OFF_KIND.match(text)
    bad = f"{where}: cannot be read as off"
    if head is None or head[4] or head[5]:
        raise InputError(f"{bad} (it does not begin with OFF); export it again")
    # Colours of faces may follow on their lines, so the faces are read line by line.
    lines = [line for line in text[head.end() :].split(b"\n") if line.strip()]
    try:
        vertices, faces = (int(word) for word in lines[0].split()[:2])
        check_counts(where, vertices, faces)
        if vertices + faces >= len(lines) or min(vertices, faces) < 0:
            raise ValueError(f"{len(lines)} lines, too few for what its header says")
        rows = parsed(b"\n".join(lines[1 : 1 + vertices]), np.float64)
        width = len(rows) // max(vertices, 1)
        if width < 3 or width * vertices != len(rows):
            raise ValueError("a vertex has no three numbers")
        rows = rows.reshape(vertices, width)
        words = [line.split() for line in lines[1 + vertices : 1 + vertices + faces]]
        counts = np.array([int(row[0]) for row in words], np.int64)
        corners = np.array(
            [int(w) for row, n in zip(words, counts.tolist(), strict=True) for w in row[1 : 1 + n]], np.int64
        )
        if len(corners) != counts.sum():
            raise ValueError("a face is cut off")
    except InputError:
        raise
    except (ValueError, IndexError, OverflowError) as error:
        raise InputError(f"{bad} ({' '.join(str(error).split())[:100]}); is it whole? export it again") from None
    if not len(corners) or not (counts >= 3).any():
        raise InputError(f"{where}: holds no triangles; export it with its faces")
    if corners.min() < 0 or corners.max() >= vertices:
        raise InputError(
            f"{where}: a face names vertex {corners.max()}, out of range, it has {vertices}; export it again"
        )
    keep = np.repeat(counts >= 3, counts)
    corners, counts = corners[keep], counts[counts >= 3]
    check_counts(where, triangles=int(counts.sum()) - 2 * len(counts))
    # Between x y z and the end stand a normal (N) and UVs (ST); colours come before those.
    normals = rows[:, 3:6] if head[3] and not head[2] and width >= 6 else None
    uv = rows[:, -2:] if head[1] and width >= 5 else None
    cut, _ = triangulate(rows[:, :3], corners, counts)
    return RawMesh(np.ascontiguousarray(rows[:, :3]), corners[cut], uv, normals)
