"""What a place of a picture shows: which part of the cloth, read from the G-buffers."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from ..geometry.raw import Names
from ..gpu.gbuffer import GBuffer
from .cloth import ClothSurface
from .target import Target


class Picked(NamedTuple):
    """A place of cloth: the number of the cloth, the names of the part, and its number in the fabric mask; 0: it has none."""

    cloth: int
    names: Names
    mask: int


OPEN = Picked(-1, (), 0)  # a place that is cut out


def pick(target: Target, cloths: Sequence[ClothSurface], x: float, y: float) -> Picked | None:
    """The cloth at a place of the picture on a target, `x` and `y` from 0 to 1 from its top left corner; None: there is none."""
    for number, cloth in enumerate(cloths):
        buffer = target.part(cloth).buffer
        held = buffer.drawn is not None and buffer.drawn.mesh is cloth.buffers
        triangle = _triangle_at(buffer, x, y) if held else None
        if triangle is None:
            continue
        mesh = cloth.original
        first = triangle // max(len(cloth.mesh.triangles) // len(mesh.triangles), 1)  # before it was subdivided
        part = () if mesh.part_of is None or not mesh.parts else mesh.parts[int(mesh.part_of[first])]
        return Picked(number, part, cloth.mask_number)
    return None


def _triangle_at(buffer: GBuffer, x: float, y: float) -> int | None:
    """The triangle that a place shows, if it shows one."""
    width, height = buffer.size
    return buffer.triangle_at(min(int(x * width), width - 1), min(int((1.0 - y) * height), height - 1))
