"""Read Radiance pictures (.hdr): all eight orientations, both run-length codes or none, RGBE and XYZE, EXPOSURE.

OpenImageIO decodes the usual code; this reads the header, and decodes the older ones.
[Ward, "Real Pixels", Graphics Gems II; Radiance File Formats, 2006]
"""

from __future__ import annotations

import re
import tempfile
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from ..errors import InputError
from ..progress import warn
from .common import broken, check_pixels, decoded
from .primaries import converted, rec709_from, rec709_from_xyz

MOST_HEADER = 1 << 16
RESOLUTION = re.compile(rb"([+-])([XY])[ \t]+(\d{1,9})[ \t]+([+-])([XY])[ \t]+(\d{1,9})[ \t]*$")


@dataclass
class _Header:
    """What a header says.

    Parameters
    ----------
    scale : [3] that pixels are to be divided by
    lines, across : scanlines, and pixels of each
    turned : scanlines are columns
    outer_flipped, inner_flipped : the first line is the lowest or the right one; its first pixel is
    body : where the pixels begin
    """

    scale: np.ndarray = field(default_factory=lambda: np.ones(3))
    xyz: bool = False
    primaries: tuple[float, ...] = ()
    lines: int = 0
    across: int = 0
    turned: bool = False
    outer_flipped: bool = False
    inner_flipped: bool = False
    body: int = 0


def read_radiance(path: Path, blob: bytes) -> np.ndarray:
    """Pixels [H, W, 3] float32 of a file's bytes, linear Rec. 709, the first row on top.

    EXPOSURE and COLORCORR are divided out, so that pixels are radiances. PRIMARIES and XYZE become Rec. 709. Raises
    InputError for a file that is damaged or too large.
    """
    header = _header(path, blob)
    check_pixels(path, header.across, header.lines, len(blob))
    pixels = _decoded(path, blob, header)
    if header.turned:
        pixels = pixels.swapaxes(0, 1)
    flip_y, flip_x = header.outer_flipped, header.inner_flipped
    if header.turned:
        flip_y, flip_x = flip_x, flip_y
    pixels = pixels[:: -1 if flip_y else 1, :: -1 if flip_x else 1]
    if (header.scale != 1).any():
        pixels = pixels / header.scale.astype(np.float32)
    matrix = _matrix(header)
    if matrix is not None:
        warn(f"{path}: its colours are converted to Rec. 709, white adapted by Bradford")
        pixels = converted(pixels, matrix)
    return np.ascontiguousarray(pixels, np.float32)


def _matrix(header: _Header) -> np.ndarray | None:
    if header.xyz:
        return rec709_from_xyz((1 / 3, 1 / 3))
    return rec709_from(header.primaries) if header.primaries else None


def _header(path: Path, blob: bytes) -> _Header:
    header = _Header()
    at = 0
    while True:
        end = blob.find(b"\n", at, MOST_HEADER)
        if end < 0:
            raise broken(path, "its header has no end")
        line, at = blob[at:end].rstrip(b"\r"), end + 1
        if not line.strip() and at > 2:
            break
        if match := RESOLUTION.match(line):  # some writers leave out the empty line
            return _resolved(path, header, match, at)
        _variable(path, header, line)
    end = blob.find(b"\n", at, MOST_HEADER)
    match = RESOLUTION.match(blob[at:end].rstrip(b"\r")) if end >= 0 else None
    if match is None:
        raise broken(path, "its header gives no size such as -Y 512 +X 1024")
    return _resolved(path, header, match, end + 1)


def _variable(path: Path, header: _Header, line: bytes) -> None:
    """One line NAME=value of a header."""
    name, separator, value = line.partition(b"=")
    name, text = name.strip().upper(), value.decode("latin-1").strip()
    if not separator:
        return
    if name == b"FORMAT":
        if text.lower() not in ("32-bit_rle_rgbe", "32-bit_rle_xyze"):
            raise broken(path, f"its format is {text[:40]}, expected 32-bit_rle_rgbe")
        header.xyz = text.lower().endswith("xyze")
    elif name in (b"EXPOSURE", b"COLORCORR", b"PRIMARIES"):
        try:
            numbers = tuple(float(word) for word in text.split())
        except ValueError:
            numbers = ()
        if name == b"PRIMARIES":
            header.primaries = numbers
        elif len(numbers) == (1 if name == b"EXPOSURE" else 3) and all(1e-30 < abs(n) < 1e30 for n in numbers):
            header.scale = header.scale * np.array(numbers)
        else:
            warn(f"{path}: {name.decode()}={text[:40]} is no number, it is left out")


def _resolved(path: Path, header: _Header, match: re.Match, body: int) -> _Header:
    """A header with its size: `-Y H +X W` is rows from the top, each from the left."""
    outer, inner = match[2], match[5]
    if outer == inner:
        raise broken(path, "its header gives no size such as -Y 512 +X 1024")
    header.lines, header.across, header.body = int(match[3]), int(match[6]), body
    header.turned = outer == b"X"
    # +Y counts up from the bottom, -X from the right: of the outer axis, and of the inner one.
    header.outer_flipped = match[1] == (b"-" if header.turned else b"+")
    header.inner_flipped = match[4] == (b"+" if header.turned else b"-")
    if not header.lines or not header.across:
        raise InputError(f"{path}: holds no pixels, expected a picture; save it again")
    return header


# Pixels -----------------------------------------------------------------------------------------------------------


def _decoded(path: Path, blob: bytes, header: _Header) -> np.ndarray:
    """The scanlines [lines, across, 3] in the file's order."""
    body = blob[header.body :]
    new = 8 <= header.across <= 0x7FFF and body[:2] == b"\x02\x02" and len(body) > 3 and body[2] < 0x80
    if new:
        # At best 127 equal pixels take two bytes.
        if len(body) < header.lines * (4 + 8 * (header.across // 127)):
            raise broken(path)
        return _by_library(path, body, header)
    quads = np.frombuffer(body, np.uint8, len(body) // 4 * 4).reshape(-1, 4)
    return _floats(_without_runs(path, quads, header.lines * header.across)).reshape(header.lines, header.across, 3)


def _by_library(path: Path, body: bytes, header: _Header) -> np.ndarray:
    """The scanlines as OpenImageIO decodes them under a plain header."""
    size = f"-Y {header.lines} +X {header.across}\n"
    with tempfile.NamedTemporaryFile(suffix=".hdr") as file:
        file.write(b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n" + size.encode() + body)
        file.flush()
        pixels = decoded(file.name, path)
    if pixels.shape[:2] != (header.lines, header.across):
        raise broken(path)
    return pixels[..., :3]


def _without_runs(path: Path, quads: np.ndarray, count: int) -> np.ndarray:
    """Pixels [count, 4]: each one, or, older: 1 1 1 n repeats the last one n times; a second such has n of 256 each."""
    run = (quads[:, :3] == 1).all(1)
    if not run.any():
        if len(quads) < count:
            raise broken(path)
        return quads[:count]
    place = np.arange(len(quads))
    # How many repeats stand in a row before each one.
    last_pixel = np.maximum.accumulate(np.where(run, -1, place))
    shift = np.minimum(place - last_pixel - 1, 3)
    times = np.where(run, quads[:, 3].astype(np.int64) << (8 * np.maximum(shift, 0)), 1)
    total = np.cumsum(times)
    enough = int(np.searchsorted(total, count))
    if last_pixel[0] < 0 or enough >= len(quads):
        raise broken(path)
    times = times[: enough + 1]
    times[-1] -= total[enough] - count
    return quads[np.repeat(last_pixel[: enough + 1], times)]


def _floats(quads: np.ndarray) -> np.ndarray:
    """Colours [N, 3] float32: mantissa times 2^(exponent - 136)."""
    scale = np.ldexp(np.float32(1), quads[:, 3].astype(np.int32) - 136)
    return quads[:, :3] * np.where(quads[:, 3:] > 0, scale[:, None], np.float32(0)).astype(np.float32)
