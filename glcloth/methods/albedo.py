"""How much of the light that falls on a fabric it gives back: what a diffuse bounce needs to know of it."""

from __future__ import annotations

import numpy as np

from ..fabric import Fabric
from ..twins.cloth import f_cloth

PAIRS = 1 << 15  # of directions: an error of about 1 % with lobes of a few degrees
# Root of x^5 = x + 1: its powers make the evenly spread sequence of four dimensions (Roberts 2018).
GOLDEN_4 = 1.1673039782614187


def diffuse_albedo(fabric: Fabric) -> np.ndarray:
    """Reflected share [3] of uniform light from the whole hemisphere (bihemispherical albedo).

    (1 / pi) integral over omega_o of cos(theta_o) times the white furnace's radiance toward omega_o: the albedo of the
    Lambertian that gives back as much.
    """
    u = (0.5 + np.arange(1, PAIRS + 1)[:, None] / GOLDEN_4 ** np.arange(1, 5)) % 1.0
    # omega_o with the density cos(theta_o) / pi, omega_i evenly over the hemisphere.
    omega_o = _direction(np.sqrt(u[:, 0]), u[:, 1])
    omega_i = _direction(u[:, 2], u[:, 3])
    f = f_cloth(omega_i, omega_o, *fabric.arrays())
    return 2 * np.pi * f.mean(0)


def _direction(z: np.ndarray, turn: np.ndarray) -> np.ndarray:
    """Unit directions [N, 3] of given height and azimuth (0 to 1)."""
    r, phi = np.sqrt(1 - z * z), 2 * np.pi * turn
    return np.stack([r * np.cos(phi), r * np.sin(phi), z], -1)
