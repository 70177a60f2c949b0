"""How far the bending of simulated cloth is from the elastica: the sag of a strip that is clamped at one end.

python tests/measure/bending.py

Columns: bending D (N m), length of the strip (m, so chosen that its weight bends it alike), cells along it, substeps a second,
D h^2 / (mass cell^4), sag of its tip over that of the elastica D theta'' = -w (L - s) cos(theta). Mass 0.2 kg/m^2, 2.5 s of
strong damping.
"""

import common
import numpy as np
from scipy.integrate import solve_bvp

from glcloth.gpu.context import create_context
from glcloth.simulation.cloth import Cloth, ClothParameters

MASS, WEIGHT = 0.2, 5.0  # kg/m^2; w L^3 / D
RATIOS = (0.005, 0.02, 0.1, 0.5)  # D h^2 / (mass cell^4)


def elastica(weight):
    """Sag of the tip over the length."""
    s = np.linspace(0, 1, 101)
    found = solve_bvp(
        lambda s, y: np.stack([y[1], -weight * (1 - s) * np.cos(y[0])]),
        lambda a, b: np.array([a[0], b[1]]),
        s,
        np.stack([-0.5 * s, -0.5 * np.ones_like(s)]),
    )
    return np.trapezoid(np.sin(found.sol(s)[0]), s)


def sag(ctx, D, length, cells, rate):
    """Sag of the tip over the length; the clamp holds the first two columns, so the free length begins mid cell."""
    cell = length / (cells - 0.5)
    x, z = np.meshgrid(cell * np.arange(cells + 1), cell * np.arange(4))
    pinned = np.zeros(x.shape, bool)
    pinned[:, :2] = True
    parameters = ClothParameters(
        (cell, cell), MASS, stretch=1e5, shear=0.0, bending=D, damping=20.0, drag=(0, 0), substeps=rate // 60,
    )  # fmt: skip
    cloth = Cloth(ctx, parameters, np.stack([x, 0 * x, z], -1), (), pinned)
    for _ in range(150):
        cloth.step(1 / 60)
    tip = -cloth.positions()[:, -1, 1].mean()
    cloth.release()
    return tip / length


if __name__ == "__main__":
    context, exact = create_context(), elastica(WEIGHT)
    common.head("D", "length", "cells", "substeps /s", "D h^2 / (mass cell^4)", "sag over elastica")
    for D in (3e-5, 3e-4, 2e-3):
        length = (WEIGHT * D / (MASS * 9.81)) ** (1 / 3)
        for cells in (6, 12):
            for ratio in RATIOS:
                cell = length / (cells - 0.5)
                rate = 60 * max(1, round((D / (MASS * cell**4 * ratio)) ** 0.5 / 60))
                found = D / rate**2 / (MASS * cell**4)
                common.row(f"{D:g}", f"{length:.3f}", cells, rate, f"{found:.3f}",
                           f"{sag(context, D, length, cells, rate) / exact:.3f}")  # fmt: skip
