"""Fit spherical Gaussians and suns to an environment so that cloth lit by them looks as it does under the map.

Plain least squares on radiance spends its lobes on what cloth cannot see. Cloth is a linear operator on the
environment, L = <K, L_env>; over random frames and views the mean squared error of a residual r is exactly

    E |dL|^2 = sum_l Q_l sum_m |r_lm|^2,      Q_l = mean of sum_m |K_lm|^2 / (2 l + 1)

so the fit minimises that (lobes.py). Small bright lights are split off first as directional suns (suns.py).   [own]
"""

from __future__ import annotations

import contextlib
import hashlib
import itertools
from pathlib import Path

import numpy as np
from threadpoolctl import threadpool_limits

from ..color import LUMINANCE
from ..errors import InputError
from ..files import atomic_write, cache_dir
from ..progress import track, warn
from . import harmonics
from .bands import band_weights
from .environment import BUILT_IN_NAMES, Environment, load_environment
from .lights import Lights, SphericalGaussians, Suns, as_lights
from .lobes import fit_lobes
from .suns import split_suns

# Part of the cache key: another number when the same map would be fitted differently.
VERSION = 4
MAX_LOBES = 64
# Fits of built-in environments by the default number of lobes; `python -m glcloth.light.fit` writes them.
SHIPPED = Path(__file__).parent / "fits"
SHIPPED_LOBES = 10
TARGET = 0.03  # relative rms of the shading
AUTO_LOBES = (5, 10, 16, 24, 40, 64)


def fit_lights(
    environment: Environment,
    lobes: int | str = 10,
    target: float = TARGET,
    weights: str | np.ndarray | None = None,
    cache: bool = True,
) -> Lights:
    """Fit spherical Gaussians, and suns beside them, to an environment.

    Parameters
    ----------
    lobes : number of Gaussians, 1..64, or "auto": the fewest of 5, 10, 16, 24, 40, 64 whose predicted error is at
        most `target` (relative rms of the shading)
    weights : a fabric's name or b_l [33] to fit for; None is the generic curve, nearly as good for every fabric
    cache : keep the fit in files.cache_dir(), keyed by the map's content, so that it is made once

    Deterministic. Raises InputError on a wrong number of lobes, target or weights.
    """
    return fitted(environment, lobes, target, weights, cache)[0]


def predicted_error(
    environment: Environment | np.ndarray, lights: Lights | SphericalGaussians, fabric: str | np.ndarray = "generic"
) -> float:
    """Expected rms error of shaded luminance over random frames, relative to its mean, of lights against their map.

    Takes the environment or its coefficients [1089, 3] (harmonics.transform), and a fabric's name or its b_l [33].
    Measured against brute force the true rms is 0.9 to 1.6 times this; the median error of a point is about 0.6 of it.
    """
    coefficients = environment if isinstance(environment, np.ndarray) else coefficients_of_map(environment)
    b = checked_weights(fabric)
    residual = (coefficients - coefficients_of(as_lights(lights))) @ LUMINANCE
    mean = abs(coefficients[0] @ LUMINANCE)
    return float(np.sqrt((b**2 * harmonics.power(residual)).sum()) / max(mean, 1e-300))


def coefficients_of_map(environment: Environment) -> np.ndarray:
    """Coefficients [1089, 3] of a map; small lamps count where they are, not at the centre of a coarse texel."""
    suns, rest = split_suns(environment.radiance)
    return harmonics.transform(rest) + harmonics.project_directions(suns.direction, suns.irradiance)


def coefficients_of(lights: Lights) -> np.ndarray:
    """Coefficients [1089, 3] of lights."""
    g, s = lights.gaussians, lights.suns
    flux = g.amplitude * harmonics.gaussian_flux(g.sharpness)[:, None]
    return harmonics.project_gaussians(g.axis, g.sharpness, flux) + harmonics.project_directions(
        s.direction, s.irradiance
    )


def checked_weights(weights: str | np.ndarray | None) -> np.ndarray:
    """The weights b_l [33] of degrees: given, or of a fabric. Raises InputError."""
    if weights is None or isinstance(weights, str):
        return band_weights(weights or "generic")
    b = np.asarray(weights, float)
    if b.shape != (harmonics.L_MAX + 1,) or not np.all(np.isfinite(b)) or np.any(b < 0) or b[0] == 0:
        raise InputError(
            f"fit: weights of shape {b.shape}, expected {harmonics.L_MAX + 1} finite numbers >= 0, the first above 0"
        )
    return b


def _check_lobes(lobes: int | str) -> int | str:
    if lobes == "auto":
        return lobes
    try:
        count = int(lobes)
        whole = not isinstance(lobes, bool) and float(lobes) == count
    except (TypeError, ValueError):
        whole = False
    if not whole or not 1 <= count <= MAX_LOBES:
        raise InputError(f'lobes {lobes!r}: expected a whole number from 1 to {MAX_LOBES}, or "auto"')
    return count


def fitted(
    environment: Environment, lobes: int | str, target: float, weights: str | np.ndarray | None, cache: bool
) -> tuple[Lights, bool]:
    """The lights of `fit_lights`, and whether they were kept."""
    lobes = _check_lobes(lobes)
    if not (np.isscalar(target) and np.isfinite(target) and target > 0):
        raise InputError(f"fit: target {target!r}, expected a relative error above 0, such as 0.03")
    b = checked_weights(weights)
    if cache and (lights := _shipped(environment, lobes, b)) is not None:
        return lights, True
    path = _cache_path(environment, lobes, target, b) if cache else None
    if path is not None and (lights := _load_cached(path, lobes)) is not None:
        return lights, True
    lights = _compute(environment, lobes, target, b)
    if path is not None:
        _save_cached(path, lights)
    return lights, False


def _compute(environment: Environment, lobes: int | str, target: float, b: np.ndarray) -> Lights:
    # The matrices are small: threads of BLAS only get into each other's way (measured 2 to 10 times slower), and with
    # one of them the result is the same on every machine that has the same library.
    with threadpool_limits(1, user_api="blas"):
        return _compute_alone(environment, lobes, target, b)


def _compute_alone(environment: Environment, lobes: int | str, target: float, b: np.ndarray) -> Lights:
    suns, rest = split_suns(environment.radiance)
    coefficients = harmonics.transform(rest)
    sun_coefficients = harmonics.project_directions(suns.direction, suns.irradiance)
    counts = AUTO_LOBES if lobes == "auto" else (lobes,)
    for count in counts:
        # Steps of L-BFGS are not known beforehand; the bar counts them.
        bar = iter(track(itertools.count(), f"fitting {count} lobes to {environment.name}"))
        with contextlib.closing(bar):
            axis, sharpness, flux, _ = fit_lobes(coefficients, b**2, count, step=lambda bar=bar: next(bar))
        amplitude = flux / harmonics.gaussian_flux(sharpness)[:, None]
        lights = Lights(SphericalGaussians(axis, sharpness, amplitude), suns)
        if lobes == "auto" and predicted_error(coefficients + sun_coefficients, lights, b) <= target:
            break
    else:
        if lobes == "auto":
            error = predicted_error(coefficients + sun_coefficients, lights, b)
            warn(
                f"{environment.name}: {count} lobes leave a predicted error of {error:.1%}, above the target of "
                f"{target:.1%}; use --light map for this one"
            )
    return lights


# The cache --------------------------------------------------------------------------------------------------------


def shipped_path(name: str, lobes: int) -> Path:
    """The file of this package with the fit of a built-in environment."""
    return SHIPPED / f"{name}_{lobes}_{VERSION}.npz"


def _shipped(environment: Environment, lobes: int | str, b: np.ndarray) -> Lights | None:
    """The fit that comes with the package; None where there is none.

    It is the same on every machine, where another library's rounding would end elsewhere in the last digits.
    """
    if lobes == "auto" or not environment.built_in or not np.array_equal(b, band_weights("generic")):
        return None
    return _load_cached(shipped_path(environment.name, int(lobes)), lobes)


def _cache_path(environment: Environment, lobes: int | str, target: float, b: np.ndarray) -> Path:
    key = hashlib.sha256()
    key.update(repr((VERSION, environment.radiance.shape, lobes, target if lobes == "auto" else None)).encode())
    key.update(np.asarray(b, "<f8").tobytes())
    key.update(memoryview(environment.radiance).cast("B"))
    return cache_dir() / "fits" / f"{key.hexdigest()[:32]}.npz"


def _load_cached(path: Path, lobes: int | str) -> Lights | None:
    """The cached lights, or None when there are none or the file is of no use (it is then made again)."""
    try:
        with np.load(path, allow_pickle=False) as data:
            lights = Lights(
                SphericalGaussians(data["axis"], data["sharpness"], data["amplitude"]),
                Suns(data["direction"], data["irradiance"], data["radius"]),
            )
    except Exception:  # a damaged archive raises almost anything; all of it means the same
        return None
    return lights if lobes == "auto" or len(lights.gaussians) == lobes else None


def _save_cached(path: Path, lights: Lights) -> None:
    g, s = lights.gaussians, lights.suns
    # A cache that cannot be written costs time, not the picture.
    with contextlib.suppress(InputError, OSError):
        path.parent.mkdir(parents=True, exist_ok=True)
        with atomic_write(path) as temporary, open(temporary, "wb") as file:
            np.savez(
                file,
                axis=g.axis,
                sharpness=g.sharpness,
                amplitude=g.amplitude,
                direction=s.direction,
                irradiance=s.irradiance,
                radius=s.radius,
            )


def ship() -> None:
    """Fit the built-in environments anew and write the files of this package."""
    for name in BUILT_IN_NAMES:
        _save_cached(shipped_path(name, SHIPPED_LOBES), fit_lights(load_environment(name), SHIPPED_LOBES, cache=False))


if __name__ == "__main__":
    ship()
