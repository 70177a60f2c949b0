"""Fabric masks: which of several fabrics a place of the cloth has, by the colours of a picture over its UVs.   [own]

One cloth becomes several, each with the triangles that may show its fabric; where a triangle shows another the pixels are
discarded. So a mask needs nothing of a method, and a place has one fabric, never a mixture.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..color import hex_codes, is_hex
from ..errors import InputError
from ..geometry.mesh import Mesh
from ..geometry.parts import taken
from ..image import decode_bytes, read_image
from ..scene import ClothMap
from .uv_pictures import FOUR_PLACES, has_codes, lie, uv_places

NEAR = 64  # of 255 codes in each channel: that far from a colour, or farther, a place has not its fabric
BAND = 1 << 20  # texels at a time, for memory
MOST_TEXELS = 8192  # a side; of larger pictures every second, third ... texel is taken
LISTED = 6  # colours that an error names


@dataclass(frozen=True, eq=False)
class FabricMask:
    """A mask as a picture.

    Parameters
    ----------
    codes : [H, W, 3] uint8, the first row at v = 0
    repeat : what one repeat covers, along u and v
    in_metres : whether that is in metres and not in UV units
    """

    codes: np.ndarray
    repeat: tuple[float, float]
    in_metres: bool

    def numbers(self, colors: Sequence[str]) -> np.ndarray:
        """Which colour each texel has [H, W]: 0 none of them, 1 the first of `colors`."""
        out = np.zeros(self.codes.shape[:2], np.uint8)
        wanted = [_codes(color) for color in colors]
        for rows in self._bands():
            codes, nearest = self.codes[rows].astype(np.int16), np.int16(NEAR)
            for number, color in enumerate(wanted, 1):
                distance = np.abs(codes - color).max(-1)
                out[rows][distance < nearest] = number
                nearest = np.minimum(nearest, distance)
        return out

    def has(self, color: str) -> bool:
        """Whether any place has a colour."""
        wanted = _codes(color)
        return any((np.abs(self.codes[rows].astype(np.int16) - wanted).max(-1) < NEAR).any() for rows in self._bands())

    def _bands(self) -> list[slice]:
        height, width = self.codes.shape[:2]
        step = max(BAND // width, 1)
        return [slice(first, first + step) for first in range(0, height, step)]

    def common(self) -> str:
        """Its commonest colours, for an error."""
        counts: Counter[int] = Counter()
        for rows in self._bands():
            keys, times = np.unique(self.codes[rows].reshape(-1, 3) @ np.array((65536, 256, 1)), return_counts=True)
            counts.update(dict(zip(keys.tolist(), times.tolist(), strict=True)))
        names = [f"#{key:06x}" for key, _ in sorted(counts.items(), key=lambda one: (-one[1], one[0]))]
        return ", ".join(names[:LISTED]) + (" ..." if len(names) > LISTED else "")


@dataclass(frozen=True, eq=False)
class Masked:
    """Where a piece of cloth is: the places of a mask that have its number.

    Parameters
    ----------
    numbers : [H, W] uint8, the first row at v = 0
    number : of the piece
    repeat : UV units of one repeat, along u and v
    piece, whole : its mesh, and the one that it was cut from
    """

    numbers: np.ndarray
    number: int
    repeat: tuple[float, float]
    piece: Mesh
    whole: Mesh

    def number_at(self, uv: np.ndarray) -> int:
        """The number of a place [2] of the whole mesh."""
        return int(_numbers_at(self.numbers, uv / np.array(self.repeat)))

    def shown_at(self, uv: np.ndarray) -> np.ndarray:
        """Whether places [N, 2] have its number."""
        return _numbers_at(self.numbers, uv / np.array(self.repeat)) == self.number

    def mostly(self, mesh: Mesh) -> np.ndarray:
        """The triangles [T] that show this number more than any other, a smaller one at a draw: each hides light once."""
        found = np.sort(_numbers_at(self.numbers, uv_places(mesh, FOUR_PLACES) / self.repeat), 0)
        counts = (found[:, None] == found).sum(0)
        return np.take_along_axis(found, counts.argmax(0)[None], 0)[0] == self.number


def load_mask(entry: ClothMap) -> FabricMask:
    """Read a fabric mask: the codes of a PNG or JPEG, the values of others, as they are. Raises InputError as `read_image`."""
    path = Path(entry.file)
    if has_codes(path):
        codes = decode_bytes(path)[::-1]
    else:
        codes = np.rint(255.0 * np.nan_to_num(read_image(path)[::-1, :, :3]).clip(0.0, 1.0)).astype(np.uint8)
    step = -(-max(codes.shape[:2]) // MOST_TEXELS)
    return FabricMask(np.ascontiguousarray(codes[::step, ::step]), *lie(entry, codes))


def check_colors(masks: Mapping[str, FabricMask], colors: Sequence[str]) -> None:
    """Raise InputError where masks and the colours that have a fabric do not go together."""
    if not masks and colors:
        raise InputError(
            f"fabrics: {colors[0]} is a colour of a fabric mask, and there is none; give --fabric-mask FILE"
        )
    if masks and not colors:
        said = next(iter(masks.values())).common()
        raise InputError(
            f"fabric_mask: no colour has a fabric, and the picture has {said}; give --fabric '#rrggbb=NAME' for some"
        )
    for color in colors:
        if not any(mask.has(color) for mask in masks.values()):
            said = "; ".join(mask.common() for mask in masks.values())
            raise InputError(f"fabrics: no place of the fabric mask has the colour {color}, expected some of {said}")


def split(mesh: Mesh, mask: FabricMask, colors: Sequence[str], scale: float) -> list[tuple[int, Mesh, Masked]]:
    """A cloth taken apart: for each number of the mask that it shows the triangles that may show it.

    scale : a UV unit of the mesh in the unit of the mask's repeat
    """
    numbers = mask.numbers(colors)
    repeat = mask.repeat[0] / scale, mask.repeat[1] / scale
    corners = uv_places(mesh, np.eye(3)) / repeat * numbers.shape[::-1]
    low, high = np.floor(corners.min(0)).astype(int) - 1, np.floor(corners.max(0)).astype(int) + 2
    pieces = []
    for number in np.unique(numbers).tolist():
        if (shows := _count(numbers == number, low, high) > 0).any():
            piece = taken(mesh, shows)
            pieces.append((number, piece, Masked(numbers, number, repeat, piece, mesh)))
    return pieces


def mask_colors(patterns: Iterable[str]) -> list[str]:
    """Those of the keys of `Scene.fabrics` that are colours of a mask."""
    return [pattern for pattern in patterns if is_hex(pattern)]


def part_pattern(name: str) -> str:
    """The pattern of a part by its name: one that looks like a colour of a mask has a ? for the #."""
    return f"?{name[1:]}" if is_hex(name) else name


def _codes(color: str) -> np.ndarray:
    return np.rint(255.0 * np.array(hex_codes(color))).astype(np.int16)


def _numbers_at(numbers: np.ndarray, at: np.ndarray) -> np.ndarray:
    """The texels at places [..., 2] in repeats, of a picture that repeats."""
    size = np.array(numbers.shape[::-1])
    column, row = np.moveaxis(np.floor(at * size).astype(int) % size, -1, 0)
    return numbers[row, column]


def _count(wanted: np.ndarray, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """How many texels of a picture that repeats are wanted [H, W] from `low` up to `high` [..., 2] (column, row)."""
    sums = np.zeros((wanted.shape[0] + 1, wanted.shape[1] + 1), np.int32)
    np.cumsum(wanted, 0, np.int32, out=sums[1:, 1:])
    np.cumsum(sums[1:, 1:], 1, np.int32, out=sums[1:, 1:])

    def before(column: np.ndarray, row: np.ndarray) -> np.ndarray:
        (rows, r), (columns, c) = np.divmod(row, wanted.shape[0]), np.divmod(column, wanted.shape[1])
        return rows * columns * int(sums[-1, -1]) + rows * sums[-1, c] + columns * sums[r, -1] + sums[r, c]

    (x_0, y_0), (x_1, y_1) = np.moveaxis(low, -1, 0), np.moveaxis(high, -1, 0)
    return before(x_1, y_1) - before(x_0, y_1) - before(x_1, y_0) + before(x_0, y_0)
