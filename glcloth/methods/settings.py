"""What a method may be told beside the fabric and the lights."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, get_args

from ..errors import InputError
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

    Raises InputError for a name or a kind of value that is not among these.
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

    def __post_init__(self) -> None:
        for name, known in (
            ("quality", get_args(Quality)),
            ("light", ("sg", "map")),
            ("shadows", get_args(ShadowMode)),
        ):
            if getattr(self, name) not in known:
                raise InputError(f"{name} = {getattr(self, name)!r}: expected {', '.join(known)}")
        for name in ("segments", "cube", "grid"):
            if not isinstance(getattr(self, name), int) or getattr(self, name) < 1:
                raise InputError(f"{name} = {getattr(self, name)!r}: expected a whole number above 0")
        if not isinstance(self.contribution, int | float):
            raise InputError(f"contribution = {self.contribution!r}: expected a number from 0.5 to 0.9999")
        if self.light == "map" and self.environment is None:
            raise InputError('light = "map": give the environment too, or take light = "sg"')
