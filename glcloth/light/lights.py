"""The lights of a scene as plain values: spherical Gaussians and directional suns."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ..errors import InputError

# Beyond these, squares and sums leave single precision.
SHARPEST = 1e8
BRIGHTEST = 1e12
SUN_RADIUS = float(np.radians(0.27))  # of the sun as the earth sees it: half a degree across
WIDEST_SUN = float(np.radians(10.0))  # as wide, a light is no direction any more


def _frozen(array) -> np.ndarray:
    array = np.array(array, np.float64)
    array.setflags(write=False)
    return array


def _units(name: str, vectors: np.ndarray) -> np.ndarray:
    good = (abs(vectors) <= BRIGHTEST).all()
    length = np.linalg.norm(vectors, axis=-1, keepdims=True) if good else np.zeros(1)
    if not good or np.any(length < 1e-12):
        raise InputError(
            f"lights: {name} has a zero, huge or non-finite vector, expected directions; give unit vectors"
        )
    # A vector that is unit up to rounding stays as it is, so that saved lights read back bit for bit.
    return np.where(np.abs(length - 1) < 1e-15, vectors, vectors / length)


@dataclass(frozen=True)
class SphericalGaussians:
    """K spherical Gaussians: radiance(omega) = sum_k amplitude_k exp(sharpness_k (omega . axis_k - 1)).   [Miz 1, 7]

    Parameters
    ----------
    axis : [K, 3] directions toward the light (normalised here)
    sharpness : [K] 2 / sigma_k^2, >= 0
    amplitude : [K, 3] linear Rec. 709 radiance at the axis

    Raises InputError on wrong shapes, amplitudes above 1e12 and a sharpness that is not from 0 to 1e8.
    """

    axis: np.ndarray
    sharpness: np.ndarray
    amplitude: np.ndarray

    def __post_init__(self):
        axis = np.asarray(self.axis, float).reshape(-1, 3) if np.size(self.axis) else np.zeros((0, 3))
        sharpness = np.asarray(self.sharpness, float).reshape(-1)
        amplitude = np.asarray(self.amplitude, float).reshape(-1, 3) if np.size(self.amplitude) else np.zeros((0, 3))
        if not len(axis) == len(sharpness) == len(amplitude):
            raise InputError(
                f"spherical Gaussians: axis {axis.shape}, sharpness {sharpness.shape}, amplitude {amplitude.shape}, "
                "expected [K, 3], [K], [K, 3] with one K"
            )
        if not ((sharpness >= 0) & (sharpness <= SHARPEST)).all() or not (abs(amplitude) <= BRIGHTEST).all():
            raise InputError(
                f"spherical Gaussians: expected a sharpness from 0 to {SHARPEST:.0e} and amplitudes of at most "
                f"{BRIGHTEST:.0e}; give a sharper light as a sun, and less light"
            )
        object.__setattr__(self, "axis", _frozen(_units("axis", axis)))
        object.__setattr__(self, "sharpness", _frozen(sharpness))
        object.__setattr__(self, "amplitude", _frozen(amplitude))

    def __len__(self) -> int:
        return len(self.sharpness)

    def radiance(self, omega: np.ndarray) -> np.ndarray:
        """Radiance [..., 3] from directions omega [..., 3] (unit)."""
        cos = np.asarray(omega, float) @ self.axis.T
        return np.exp(self.sharpness * (cos - 1.0)) @ self.amplitude

    def rotated(self, rotation: np.ndarray) -> SphericalGaussians:
        """The same lights turned by a rotation matrix [3, 3] (new axis = rotation @ axis)."""
        return SphericalGaussians(self.axis @ np.asarray(rotation, float).T, self.sharpness, self.amplitude)


@dataclass(frozen=True)
class Suns:
    """Directional lights: discs so far away that they look the same from everywhere. What the horizon of a fabric cuts off them
    does not light it; their shadows are as soft as the discs are wide.

    Parameters
    ----------
    direction : [S, 3] toward each sun's middle (normalised here)
    irradiance : [S, 3] linear Rec. 709 irradiance on a surface that faces the sun
    radius : [S] or one for all, radians from 0 (a point: hard shadows) to 10 degrees; by default half a degree across

    Raises InputError on wrong shapes and values.
    """

    direction: np.ndarray = field(default_factory=lambda: np.zeros((0, 3)))
    irradiance: np.ndarray = field(default_factory=lambda: np.zeros((0, 3)))
    radius: np.ndarray | float = SUN_RADIUS

    def __post_init__(self):
        direction = np.asarray(self.direction, float).reshape(-1, 3)
        irradiance = np.asarray(self.irradiance, float).reshape(-1, 3)
        if len(direction) != len(irradiance):
            raise InputError(f"suns: {len(direction)} directions but {len(irradiance)} irradiances, expected as many")
        if not (abs(irradiance) <= BRIGHTEST).all():
            raise InputError(f"suns: expected irradiances of at most {BRIGHTEST:.0e}; give less light")
        radius = np.asarray(self.radius, float)
        if radius.shape not in ((), (len(direction),)):
            raise InputError(
                f"suns: radius of shape {radius.shape}, expected one or {len(direction)} angles in radians"
            )
        if not ((radius >= 0.0) & (radius <= WIDEST_SUN)).all():
            wrong = radius[~((radius >= 0.0) & (radius <= WIDEST_SUN))].flat[0]
            raise InputError(
                f"suns: radius of {np.degrees(wrong):.4g} degrees, expected 0 to {np.degrees(WIDEST_SUN):.0f}; give a wider "
                "light as a Gaussian"
            )
        object.__setattr__(self, "radius", _frozen(np.broadcast_to(radius, len(direction))))
        object.__setattr__(self, "direction", _frozen(_units("direction", direction)))
        object.__setattr__(self, "irradiance", _frozen(irradiance))

    def __len__(self) -> int:
        return len(self.irradiance)

    def rotated(self, rotation: np.ndarray) -> Suns:
        """The same suns turned by a rotation matrix [3, 3]."""
        return Suns(self.direction @ np.asarray(rotation, float).T, self.irradiance, self.radius)


@dataclass(frozen=True)
class Lights:
    """All lights of a scene: K spherical Gaussians and a few suns. Every method takes both."""

    gaussians: SphericalGaussians
    suns: Suns = field(default_factory=Suns)

    def rotated(self, rotation: np.ndarray) -> Lights:
        """The same lights turned by a rotation matrix [3, 3]."""
        return Lights(self.gaussians.rotated(rotation), self.suns.rotated(rotation))


def as_lights(lights: Lights | SphericalGaussians) -> Lights:
    """Return `lights` as Lights; bare Gaussians have no suns."""
    return lights if isinstance(lights, Lights) else Lights(lights)
