"""The light of a traced scene: one lamp, even light, and a background for rays that leave."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..errors import InputError

Color = tuple[float, float, float]
FAR = 2000.0  # m, to a sun


@dataclass(frozen=True)
class Lamp:
    """A point that gives light and makes shadows.

    position : [3] metres; intensity : linear Rec. 709, W/sr
    radius : m, of a disc about it that faces the origin; samples of the pixels take points of it, a single one its middle

    Raises InputError for numbers that are not finite and for negative intensity.
    """

    position: Color = (0.0, 2.2, -3.0)
    intensity: Color = (60.0, 58.0, 54.0)
    radius: float = 0.0

    def __post_init__(self) -> None:
        for name in ("position", "intensity"):
            value = np.asarray(getattr(self, name), float)
            if value.shape != (3,) or not np.isfinite(value).all():
                raise InputError(f"lamp: {name} = {getattr(self, name)}, expected three finite numbers")
            object.__setattr__(self, name, tuple(float(v) for v in value))
        if min(self.intensity) < 0:
            raise InputError(f"lamp: intensity = {self.intensity}, expected 0 or more")

    @classmethod
    def of_sun(cls, direction: np.ndarray, irradiance: np.ndarray, radius: float) -> Lamp:
        """A sun in this direction [3], of this irradiance [3] across it, as wide as `radius` (radians): a lamp so far away that
        a room sees it alike from everywhere, within a thousandth."""
        place = FAR * np.asarray(direction, float) / np.linalg.norm(direction)
        light = np.maximum(FAR**2 * np.asarray(irradiance, float), 0.0)
        x, y, z = map(float, place)
        r, g, b = map(float, light)
        return cls((x, y, z), (r, g, b), FAR * float(np.tan(radius)))

    @property
    def axes(self) -> tuple[np.ndarray, np.ndarray]:
        """Half axes [3] of its disc."""
        way = np.array(self.position) / max(float(np.linalg.norm(self.position)), 1e-12)
        other = np.array([1.0, 0.0, 0.0]) if abs(way[0]) < 0.7 else np.array([0.0, 1.0, 0.0])
        x = np.cross(other, way)
        x /= max(float(np.linalg.norm(x)), 1e-12)
        return self.radius * x, self.radius * np.cross(way, x)

    def points(self, count: int) -> np.ndarray:
        """Points of its disc for so many samples, evenly spread, [count, 3]."""
        k = np.arange(count)
        u, v = (
            (0.5 + k * 0.6287067210378087) % 1.0,
            (0.5 + k * 0.5385972572236101) % 1.0,
        )  # two of R4, beside pixels and lens
        r = np.zeros(1) if count == 1 else np.sqrt(u)
        x, y = self.axes
        place = (r * np.cos(2 * np.pi * v))[:, None] * x + (r * np.sin(2 * np.pi * v))[:, None] * y
        return np.array(self.position) + place


@dataclass(frozen=True)
class Lighting:
    """The lamp; `ambient`, the radiance of even light; `background`, the radiance beyond the scene when there is no
    environment map."""

    lamp: Lamp = Lamp()
    ambient: Color = (0.15, 0.15, 0.16)
    background: Color = (0.6, 0.75, 1.0)
