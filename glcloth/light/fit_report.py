"""How well lights stand for an environment: in words, in numbers, as a picture."""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np

from ..color import LUMINANCE, luminance
from . import equirect, harmonics
from .bands import FABRICS
from .environment import Environment
from .fit import TARGET, checked_weights, coefficients_of, coefficients_of_map, fitted, predicted_error
from .lights import Lights, SphericalGaussians, as_lights
from .suns import split_suns

# The 95th percentile of an error over its root mean square, were it normal. Over the built-in maps 1.5 to 2.3 are measured.
NORMAL_95 = 1.96


@dataclass(frozen=True)
class FitReport:
    """The result of a fit, for people and for JSON.

    Parameters
    ----------
    environment, lobes : name of the map and number of Gaussians
    lights : the fit
    residual : root of the loss relative to no Gaussians at all, in the space of cloth shading (suns apart)
    predicted : {fabric: expected rms error of the shading relative to its mean}
    share_of_suns : share of the map's light (luminance) that the suns carry
    seconds : wall time; cached : whether the lights came from the cache
    """

    environment: str
    lobes: int
    lights: Lights
    residual: float
    predicted: dict[str, float]
    share_of_suns: float
    seconds: float
    cached: bool

    def __str__(self) -> str:
        g, s = self.lights.gaussians, self.lights.suns
        flux = luminance(g.amplitude) * harmonics.gaussian_flux(g.sharpness)
        whole = max(float(flux.sum() + luminance(s.irradiance).sum()), 1e-300)
        lines = [f"{self.environment}: {len(g)} lobes, {len(s)} suns ({self.share_of_suns:.0%} of the light)"]
        lines += ["      share  width  elevation  azimuth    red  green   blue"]
        widths = np.sqrt(2 / np.maximum(g.sharpness, 1e-6))
        rows = [("lobe", *row) for row in zip(flux, widths, g.axis, g.amplitude, strict=True)]
        rows += [
            ("sun ", *row) for row in zip(luminance(s.irradiance), s.radius, s.direction, s.irradiance, strict=True)
        ]
        for kind, share, radians, axis, color in rows:
            width = f"{np.degrees(radians):6.1f}"
            elevation, azimuth = np.degrees(np.arcsin(axis[1])), np.degrees(np.arctan2(axis[0], axis[2]))
            line = f"{kind} {share / whole:6.1%} {width} {elevation:10.1f} {azimuth:8.1f}"
            lines.append(line + "".join(f" {c:6.3g}" for c in color))
        lines.append(
            "angles in degrees (width: where the lobe falls to 1/e, the sun's radius; azimuth from +z toward +x)"
        )
        errors = ", ".join(f"{fabric} {e:.1%} ({NORMAL_95 * e:.1%})" for fabric, e in self.predicted.items())
        lines.append(
            f"residual {self.residual:.2%}; expected lighting error, of the mean brightness (of 95 %): {errors}"
        )
        lines.append(f"{self.seconds:.2f} s" + (" (from the cache)" if self.cached else ""))
        return "\n".join(lines)

    def as_dict(self) -> dict:
        """The report with plain numbers and lists."""
        g, s = self.lights.gaussians, self.lights.suns
        flux = g.amplitude * harmonics.gaussian_flux(g.sharpness)[:, None]
        return {
            "environment": self.environment,
            "lobes": self.lobes,
            "gaussians": [
                {"axis": x.tolist(), "sharpness": float(k), "amplitude": a.tolist(), "flux": f.tolist()}
                for x, k, a, f in zip(g.axis, g.sharpness, g.amplitude, flux, strict=True)
            ],
            "suns": [
                {"direction": d.tolist(), "irradiance": e.tolist(), "radius_deg": float(np.degrees(r))}
                for d, e, r in zip(s.direction, s.irradiance, s.radius, strict=True)
            ],
            "residual": self.residual,
            "predicted_error": dict(self.predicted),
            "predicted_error_95": {fabric: NORMAL_95 * error for fabric, error in self.predicted.items()},
            "share_of_suns": self.share_of_suns,
            "seconds": self.seconds,
            "cached": self.cached,
        }


def fit_report(
    environment: Environment,
    lobes: int | str = 10,
    weights: str | np.ndarray | None = None,
    cache: bool = True,
) -> FitReport:
    """Fit as fit_lights does and report how well it went."""
    begin = time.perf_counter()
    lights, cached = fitted(environment, lobes, TARGET, weights, cache)
    return report_on(environment, lights, time.perf_counter() - begin, cached, weights)


def report_on(
    environment: Environment,
    lights: Lights | SphericalGaussians,
    seconds: float = 0.0,
    cached: bool = False,
    weights: str | np.ndarray | None = None,
) -> FitReport:
    """Report how well given lights stand for an environment, wherever they come from."""
    lights = as_lights(lights)
    whole = coefficients_of_map(environment)
    suns = harmonics.project_directions(lights.suns.direction, lights.suns.irradiance)
    q = checked_weights(weights) ** 2
    left = (q[:, None] * harmonics.power(whole - coefficients_of(lights))).sum()
    right = (q[:, None] * harmonics.power(whole - suns)).sum()
    return FitReport(
        environment=environment.name,
        lobes=len(lights.gaussians),
        lights=lights,
        residual=float(np.sqrt(left / max(right, 1e-300))),
        predicted={fabric: predicted_error(whole, lights, fabric) for fabric in FABRICS},
        share_of_suns=float(suns[0] @ LUMINANCE / max(whole[0] @ LUMINANCE, 1e-300)),
        seconds=seconds,
        cached=cached,
    )


def fit_picture(environment: Environment, lights: Lights | SphericalGaussians, height: int = 256) -> np.ndarray:
    """The map, the lights and their difference side by side: float32 [height, 6 height, 3], linear.

    Suns are drawn in the fit as discs of 2.5 degrees with their true irradiance. The difference leaves them out on both
    sides; red is where the fit is brighter, blue where it is darker. All is scaled so that the map without its suns
    has a mean luminance of 0.25.
    """
    lights = as_lights(lights)
    width = 2 * height
    omega = equirect.texel_directions(height, width)
    _, rest = split_suns(environment.radiance) if len(lights.suns) else (None, environment.radiance)
    smooth = lights.gaussians.radiance(omega)
    fit = smooth.copy()
    radius = max(np.radians(2.5), 1.5 * np.pi / height)
    for direction, irradiance in zip(lights.suns.direction, lights.suns.irradiance, strict=True):
        fit[omega @ direction > np.cos(radius)] += irradiance / (np.pi * np.sin(radius) ** 2)
    change = luminance(smooth - equirect.resize(rest, height, width))
    signed = np.stack([np.maximum(change, 0), 0.15 * np.abs(change), np.maximum(-change, 0)], -1)
    picture = np.concatenate([equirect.resize(environment.radiance, height, width), fit, signed], 1)
    mean = float(equirect.total(rest) @ LUMINANCE) / (4 * np.pi)
    return (picture * (0.25 / max(mean, 1e-30))).astype(np.float32)
