"""What lights a traced scene: one lamp, the environment behind the window, and even light in the room."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..errors import InputError

Color = tuple[float, float, float]


@dataclass(frozen=True)
class Lamp:
    """A light that casts shadows: a point, or one so far away that only its direction counts.

    position : [3] metres; or, when `distant`, the direction toward it
    intensity : linear Rec. 709, W/sr of a point; irradiance on a surface that faces a distant lamp

    Raises InputError for numbers that are not finite, negative intensity and a direction of length 0.
    """

    position: Color = (0.0, 2.2, -3.0)
    intensity: Color = (60.0, 58.0, 54.0)
    distant: bool = False

    def __post_init__(self):
        for name in ("position", "intensity"):
            value = np.asarray(getattr(self, name), float)
            if value.shape != (3,) or not np.isfinite(value).all():
                raise InputError(f"lamp: {name} = {getattr(self, name)}, expected three finite numbers")
            object.__setattr__(self, name, tuple(float(v) for v in value))
        if min(self.intensity) < 0:
            raise InputError(f"lamp: intensity = {self.intensity}, expected 0 or more")
        if self.distant and not any(self.position):
            raise InputError("lamp: a distant lamp needs a direction, its position is (0, 0, 0)")

    @property
    def vector(self) -> tuple[float, float, float, float]:
        """(position, 1), or (unit direction, 0) of a distant lamp."""
        if not self.distant:
            return (*self.position, 1.0)
        unit = np.array(self.position) / np.linalg.norm(self.position)
        return (*map(float, unit), 0.0)


@dataclass(frozen=True)
class Lighting:
    """The lamp; `ambient`, the radiance of even light in the room; `background`, the radiance of the sky when there is no
    environment map."""

    lamp: Lamp = Lamp()
    ambient: Color = (0.15, 0.15, 0.16)
    background: Color = (0.6, 0.75, 1.0)
