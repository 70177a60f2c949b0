"""How much light a fabric reflects, and how much it may: by quadrature, once per fabric, for the tracer."""

from __future__ import annotations

import json
from functools import lru_cache

import numpy as np

from ..fabric import Fabric, Transmission
from ..twins.cloth import f_cloth
from ..twins.sheet import R_sheet, T_lambert, T_sheet, T_straight


@lru_cache(maxsize=2)
def hemisphere(rings: int = 24, sectors: int = 36) -> tuple[np.ndarray, np.ndarray]:
    """Directions [N, 3] about +z and weights [N] for integrals of f cos(theta) over the hemisphere.

    Evenly over z: what microcylinders reflect does not vanish at the horizon, and f cos / cos over sin^2 would rise there
    without end (up to 4 % less light of 16 rings).
    """
    x, w = np.polynomial.legendre.leggauss(rings)
    z = np.repeat((x + 1) / 2, sectors)
    phi = np.tile((np.arange(sectors) + 0.5) * (2 * np.pi / sectors), rings)
    r = np.sqrt(1 - z**2)
    directions = np.stack([r * np.cos(phi), r * np.sin(phi), z], -1)
    return directions, np.repeat(w * np.pi / sectors, sectors) * z


def directional_albedo(fabric: Fabric, omega_o: np.ndarray) -> np.ndarray:
    """Radiance [3] toward omega_o [3] (surface frame) under unit radiance from everywhere above."""
    directions, weight = hemisphere()
    f = f_cloth(directions, np.asarray(omega_o, float)[None], *fabric.arrays())
    return (f * (weight / directions[:, 2])[:, None]).sum(0)


def _albedos(fabric: Fabric) -> tuple[np.ndarray, np.ndarray]:
    # By its text, because a fabric that has computed arrays cannot be compared.
    return _albedos_of(fabric.model_dump_json(exclude={"name", "transmission"}))


@lru_cache(maxsize=8)
def _albedos_of(text: str) -> tuple[np.ndarray, np.ndarray]:
    fabric = Fabric(name="-", **json.loads(text))
    theta = np.radians([4.0, 25.0, 45.0, 62.0, 76.0])
    phi = np.radians([0.0, 45.0, 90.0, 160.0])
    t, p = (a.ravel() for a in np.meshgrid(theta, phi, indexing="ij"))
    omega = np.stack([np.sin(t) * np.cos(p), np.sin(t) * np.sin(p), np.cos(t)], -1)
    return omega, np.array([directional_albedo(fabric, o) for o in omega])


def mean_albedo(fabric: Fabric) -> np.ndarray:
    """The albedo [3], averaged over directions by their cosine: the fabric's colour in even light."""
    omega, albedo = _albedos(fabric)
    weight = omega[:, 2] * np.sqrt(1 - omega[:, 2] ** 2)
    return weight @ albedo / weight.sum()


def reflection_limit(fabric: Fabric) -> float:
    """The factor, at most 1, by which the reflection must be dimmed so that with all that passes or is mirrored no
    energy is gained: T_sheet (what the curtain sends straight on) or T_straight + T_lambert, and R_sheet. Nearer the
    horizon than it looks the yarns mirror up to all light, and `R_limited` holds that back.

    Paper A's model does not promise an albedo below 1, and knows nothing of light that passes.
    """
    omega, albedo = _albedos(fabric)
    room = 1.0 - (_taken(fabric.transmission, omega) if fabric.transmission else 0.0)
    with np.errstate(divide="ignore"):
        return float(min(1.0, np.min(np.where(albedo > 0, room / albedo, np.inf))))


def _taken(t: Transmission, omega: np.ndarray) -> np.ndarray:
    """The share [N, 3] of light along omega [N, 3] that passes or is mirrored."""
    tau = np.array(t.tau)
    straight = T_straight(omega, t.k_a, t.k_t, tau, t.rho, t.diffuse)
    passed = np.maximum(
        T_sheet(omega, t.k_a, t.k_t, tau, t.rho), straight + T_lambert(omega, t.k_t, tau, t.rho, t.diffuse)
    )
    return np.minimum(passed + R_sheet(omega, t.k_t, t.rho, t.eta_1, t.eta_2)[:, None], 1.0)
