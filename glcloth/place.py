"""Where an object stands: what a scene writes behind the object's name."""

from __future__ import annotations

import math
import re
from typing import NamedTuple

from .files import is_file

FARTHEST = 1e9  # metres, and times as large; farther away nothing is seen in single precision


class Place(NamedTuple):
    """Where an object stands: metres, a factor, degrees about +Y."""

    x: float = 0.0
    y: float = 0.0
    z: float = 0.0
    scale: float = 1.0
    turn_deg: float = 0.0

    @classmethod
    def of(cls, text: str) -> Place:
        """The place that x,y,z,scale,turn say; trailing ones may be missing. Raises ValueError."""
        try:
            numbers = [float(part) for part in text.split(",")] if text.strip() else []
        except ValueError:
            numbers = [math.nan]
        if len(numbers) > 5 or not all(map(math.isfinite, numbers)) or (len(numbers) > 3 and numbers[3] <= 0.0):
            raise ValueError(
                f"@{text}: expected @x,y,z,scale,turn: metres, a factor above 0, degrees; such as @0.5,0,-1,1,90"
            )
        if any(abs(number) > FARTHEST for number in numbers) or (len(numbers) > 3 and numbers[3] < 1.0 / FARTHEST):
            raise ValueError(
                f"@{text}: expected numbers of at most {FARTHEST:g}, and a factor of at least {1 / FARTHEST:g}"
            )
        return cls(*numbers)


def split_place(text: str) -> tuple[str, str]:
    """The file or name of an object, and what follows its @: where it stands. A file with an @ in its name is itself."""
    head, at, tail = text.rpartition("@")
    whole = not at or is_file(text) or not (re.fullmatch(r"[-+.\deE\s]*", tail) or "," in tail or is_file(head))
    if whole:
        return text, ""
    return head, tail
