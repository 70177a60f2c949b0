"""The light of a traced scene: one lamp, even light, and a background for rays that leave."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..errors import InputError

Color = tuple[float, float, float]


@dataclass(frozen=True)
class Lamp:
    """A point that gives light and makes shadows.

    position : [3] metres; intensity : linear Rec. 709, W/sr

    Raises InputError for numbers that are not finite and for negative intensity.
    """

    position: Color = (0.0, 2.2, -3.0)
    intensity: Color = (60.0, 58.0, 54.0)

    def __post_init__(self) -> None:
        for name in ("position", "intensity"):
            value = np.asarray(getattr(self, name), float)
            if value.shape != (3,) or not np.isfinite(value).all():
                raise InputError(f"lamp: {name} = {getattr(self, name)}, expected three finite numbers")
            object.__setattr__(self, name, tuple(float(v) for v in value))
        if min(self.intensity) < 0:
            raise InputError(f"lamp: intensity = {self.intensity}, expected 0 or more")


@dataclass(frozen=True)
class Lighting:
    """The lamp; `ambient`, the radiance of even light; `background`, the radiance beyond the scene when there is no
    environment map."""

    lamp: Lamp = Lamp()
    ambient: Color = (0.15, 0.15, 0.16)
    background: Color = (0.6, 0.75, 1.0)
