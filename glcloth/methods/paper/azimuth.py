"""T_l of equation 14, computed on the CPU: the same table for every fabric (paper A)."""

from __future__ import annotations

import numpy as np

from ...gpu.layout import shared
from ...twins import coordinates
from ...twins.azimuth import azimuth_nodes

_CONSTANTS = shared("sg/coordinates.glsl")[0]
POWERS = 10  # T_l of the powers 1-10 of cos(phi_d / 2): 1-6 for the surface term, 2-10 for the volume term


def azimuth_axes() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The nodes (phi_o, phi_k >= 0, kappa_prime) of T_l's table."""
    phi_o, phi_k, kappa = (np.linspace(0, 1, int(_CONSTANTS[f"AZIMUTH_{n}"])) for n in ("PHI_O", "PHI_K", "KAPPA"))
    return (
        coordinates.half_circle_from_unit(phi_o),
        coordinates.circle_from_unit(phi_k, _CONSTANTS["AZIMUTH_INNER"]),
        coordinates.kappa_from_unit(kappa, _CONSTANTS["KAPPA_LAST"]),
    )


def azimuth_table() -> np.ndarray:
    """T_l over azimuth_mass for the powers 1-10: [kappa_prime, phi_k, phi_o, power] float64.   [Miz 14]

    The quotient stays between 0 and 3 where T_l itself spans hundreds of decades, so that linear interpolation serves.
    """
    phi_o, phi_k, kappa = azimuth_axes()
    phi, weight = azimuth_nodes()
    cosine = np.cos((phi[:, None] - phi_o) / 2)
    powers = cosine[:, :, None] ** np.arange(1, POWERS + 1)
    # Both integrals are scaled by the Gaussian at its nearest point; far outside they would vanish in any precision.
    nearest = np.maximum(phi_k - np.pi / 2, 0)
    half = (phi - phi_k[:, None]) / 2
    fall = np.sin(half) ** 2 - np.sin(nearest / 2)[:, None] ** 2
    gaussian = weight * np.exp(-2 * kappa[:, None, None] * fall)
    mass = np.sum(gaussian * np.abs(np.cos(half)), -1)
    integrals = gaussian.reshape(-1, len(phi)) @ powers.reshape(len(phi), -1)
    return integrals.reshape(len(kappa), len(phi_k), len(phi_o), POWERS) / mass[..., None, None]
