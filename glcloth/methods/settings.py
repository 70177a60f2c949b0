"""What a method may be told beside the fabric and the lights."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

from ..scene import Quality, ShadowMode

if TYPE_CHECKING:
    import numpy as np

    from ..light.environment import Environment


@dataclass(frozen=True)
class Settings:
    """How to shade.

    Parameters
    ----------
    quality : schedule of the direct method
    segments : theta segments of the paper method   [Miz section 3.1]
    light : "sg" the fitted lights, "map" the environment itself (method reference only)
    cube : edge of the cube map whose directions the reference sums
    contribution, grid : of the paper method's tables
    shadows : "sun" hard ones of the suns, "full" those of the Gaussians too
    bounce : with shadows "full", light that goes from cloth to cloth once, as from a diffuse surface
    environment, rotation : the map, and its rotation matrix [3, 3] (new direction = rotation @ direction), for light "map"
    """

    quality: Quality = "normal"
    segments: int = 6
    light: Literal["sg", "map"] = "sg"
    cube: int = 32
    contribution: float = 0.9
    grid: int = 48
    shadows: ShadowMode = "off"
    bounce: bool = True
    environment: Environment | None = None
    rotation: np.ndarray | None = None
