"""Environments: radiance that comes from infinitely far away, as an equirectangular map, and its cube map."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np

from ..errors import InputError, meant
from ..files import path_of
from ..formats.exr import is_cube
from ..image import READABLE, read_image
from ..progress import warn
from . import cubemap, equirect
from .equirect import direction_from_uv, uv_from_direction
from .layouts import as_equirect, guessed
from .lights import Lights, SphericalGaussians, Suns, as_lights
from .skies import BUILT_IN

__all__ = [
    "BUILT_IN_NAMES",
    "Environment",
    "cube_directions",
    "cube_map",
    "cube_map_of_gaussians",
    "direction_from_uv",
    "load_environment",
    "lookup",
    "rotation_y",
    "uv_from_direction",
]

BUILT_IN_NAMES = tuple(BUILT_IN)
# Cameras and merges leave infinities; this is beyond every real source (the sun is about 5e4 in units of a white card).
LARGEST = 1e8


@dataclass(frozen=True, eq=False)  # compared by identity: arrays have no single truth value
class Environment:
    """An equirectangular map of incident radiance.

    Parameters
    ----------
    name : built-in name or file name
    radiance : float32 [H, W, 3], linear Rec. 709, finite, >= 0; +y is up, orientation as in Mitsuba's `envmap`
        (see equirect.py)
    built_in : whether it is the built-in one of this name
    """

    name: str
    radiance: np.ndarray
    built_in: bool = False

    def __post_init__(self):
        radiance = np.ascontiguousarray(self.radiance, np.float32)
        if radiance.ndim != 3 or radiance.shape[-1] != 3 or 0 in radiance.shape:
            raise InputError(f"environment {self.name}: radiance of shape {radiance.shape}, expected [H, W, 3]")
        radiance = radiance.view()
        radiance.setflags(write=False)
        object.__setattr__(self, "radiance", radiance)

    @classmethod
    def from_array(cls, radiance: np.ndarray, *, name: str = "array") -> Environment:
        """Return an environment of an array, its unusable samples replaced as those of a file are.

        radiance : [H, W, 3] linear Rec. 709, equirectangular: row 0 is the zenith (+y), the middle column looks along
            +z, u grows toward -x there; twice as wide as high, else it is stretched, with a warning

        The array is copied. Not-a-number and negative samples become 0, infinite ones the largest usable value, with one
        warning. Raises InputError for another shape, other kinds than numbers, and where every sample is 0.
        """
        try:
            array = np.array(radiance)
        except ValueError:
            array = np.zeros(0)
        if array.dtype.kind not in "iuf":
            raise InputError(f"{name}: array of {array.dtype}, expected numbers")
        with np.errstate(over="ignore"):
            return from_array(name, array.astype(np.float32))

    @property
    def mean(self) -> np.ndarray:
        """Mean radiance [3] over the sphere."""
        return equirect.total(self.radiance) / (4 * np.pi)


def load_environment(name_or_path: str | Path, layer: str = "", layout: str = "auto") -> Environment:
    """Load a built-in environment (`studio`, `sky`) or a map from a file (.exr, .hdr; .png and .jpg with a warning).

    layer : of an OpenEXR file with several; "": the picture proper
    layout : equirect, cross, strip (cube maps), angular, mirror (balls); auto: by the shape (see layouts.py)

    Samples that are no light (not a number, negative, infinite) are replaced and reported in one warning. Raises
    InputError on an unknown name (with a suggestion), an unreadable file or a black map.
    """
    text = str(name_or_path)
    if text in BUILT_IN:
        return _built_in(text)
    path = path_of(text)
    if not (path.exists() or path.suffix or "/" in text or "\\" in text):
        raise InputError(
            f"environment {text!r}: unknown; {meant(text, BUILT_IN)}give one of {', '.join(BUILT_IN)}, or a .exr or .hdr file"
        )
    if path.is_file() and path.suffix.lower() not in READABLE:
        raise InputError(
            f"{path}: cannot read {path.suffix or 'a file without suffix'} as an environment, expected .exr or .hdr"
        )
    image = read_image(path, layer)[..., :3]
    if image.shape[2] < 3:
        raise InputError(f"{path}: layer {layer}: holds no colours, expected light; choose another --layer")
    if layout == "auto":
        layout = guessed(image, path.suffix.lower() == ".exr" and is_cube(path))
        if layout != "equirect":
            warn(f"{path}: taken as a map of the layout {layout}; if it is none, choose by --env-layout")
    return from_array(path.name, as_equirect(image, layout, str(path)), source=str(path))


@lru_cache(maxsize=2)
def _built_in(name: str) -> Environment:
    return Environment(name, BUILT_IN[name](), built_in=True)


def from_array(name: str, radiance: np.ndarray, source: str | None = None) -> Environment:
    """An Environment from an array [H, W, 3]: unusable samples are replaced, with one warning.

    Not-a-number and negative samples become 0, infinite and enormous ones the largest usable value of the map. Raises
    InputError when nothing is left but black.
    """
    source = source or name
    radiance = np.ascontiguousarray(radiance, np.float32)
    if radiance.ndim != 3 or radiance.shape[-1] != 3 or 0 in radiance.shape:
        raise InputError(f"{source}: array of shape {radiance.shape}, expected [H, W, 3]")
    # One pass decides in the common case; the sum of a clean map is finite.
    if not (np.isfinite(radiance.sum(dtype=np.float64)) and radiance.min() >= 0 and radiance.max() <= LARGEST):
        radiance = _cleaned(radiance, source)
    if not radiance.any():
        raise InputError(
            f"{source}: every sample is 0, expected a map with light in it; check the file or its exposure"
        )
    height, width = radiance.shape[:2]
    if width != 2 * height:
        warn(f"{source}: {width} x {height} texels; an equirectangular map is twice as wide as high, this is stretched")
    if Path(source).suffix.lower() in (".png", ".jpg", ".jpeg"):
        warn(f"{source}: an 8-bit picture cuts bright lights at white; prefer a .hdr or .exr map")
    return Environment(name, radiance)


def _cleaned(radiance: np.ndarray, source: str) -> np.ndarray:
    nan, negative = np.isnan(radiance), radiance < 0
    huge = radiance > LARGEST
    usable = radiance[~(nan | huge)]
    largest = max(float(usable.max(initial=0.0)), 0.0)
    counts = [
        (nan, "not a number, set to 0"),
        (negative, "negative, set to 0"),
        (huge, f"infinite or above 1e8, set to {largest:.4g}"),
    ]
    said = "; ".join(f"{int(mask.sum())} {what}" for mask, what in counts if mask.any())
    warn(f"{source}: of {radiance.size} samples {said}")
    return np.where(nan | negative, np.float32(0), np.minimum(radiance, np.float32(largest)))


def lookup(environment: Environment, omega: np.ndarray) -> np.ndarray:
    """Bilinear radiance [..., 3] toward unit directions omega [..., 3]."""
    return equirect.lookup(environment.radiance, omega)


def rotation_y(degrees: float) -> np.ndarray:
    """Rotation matrix [3, 3] about +y: a positive angle turns the environment counter-clockwise seen from above.

    A light in direction d is in direction rotation_y(degrees) @ d afterwards; 90 degrees takes +z to +x.
    """
    angle = np.radians(degrees)
    # Whole quarter turns are exact, so that a full turn gives the same picture.
    c, s = (np.round(f(angle), 15) for f in (np.cos, np.sin))
    return np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])


def cube_directions(n: int = 32) -> np.ndarray:
    """Unit directions [6 n n, 3] of a cube map's texels, faces and rows in OpenGL's order (see cubemap.py)."""
    return cubemap.directions(_size(n))


def cube_map(environment: Environment, n: int = 32) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return (directions [6 n n, 3], solid_angle [6 n n], radiance [6 n n, 3]) of an environment, area-averaged.

    sum(solid_angle * radiance) is the integral of the map over the sphere, to float64 rounding.
    """
    n = _size(n)
    return cubemap.directions(n), cubemap.solid_angles(n), cubemap.average_map(environment.radiance, n)


def cube_map_of_gaussians(
    gaussians: SphericalGaussians | Lights, n: int = 32, suns: Suns | None = None
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return (directions, solid_angle, radiance) of spherical Gaussians and suns, averaged over each texel.

    Every lobe keeps its exact integral, however sharp; a sun's irradiance goes to the texel that contains it. `Lights`
    bring their own suns.
    """
    n = _size(n)
    lights = as_lights(gaussians)
    g = lights.gaussians
    radiance = cubemap.average_gaussians(g.axis, g.sharpness, g.amplitude, n)
    for group in (lights.suns, suns):
        if group is not None:
            radiance += cubemap.deposit(group.direction, group.irradiance, n)
    return cubemap.directions(n), cubemap.solid_angles(n), radiance


def _size(n: int) -> int:
    if int(n) != n or not 1 <= n <= 512:
        raise InputError(f"cube map: size {n}, expected a whole number from 1 to 512")
    return int(n)
