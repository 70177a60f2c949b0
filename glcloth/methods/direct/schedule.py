"""How many nodes the direct method spends on what: every choice a continuous function, so that no slider makes a jump.   [own]"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...fabric import Fabric, Yarn
from .gaussian_nodes import LADDER, nodes_in_row
from .lobe_nodes import Lobes


@dataclass(frozen=True)
class Schedule:
    """What a quality buys.

    Parameters
    ----------
    sharper : sharpness, for linen's lobes of 12 degrees, below which level 1, 2, ... of the ladder is used
    shift : levels added to that
    theta_count, phi_pairs : nodes of the pooled lobes of a tangent: in theta, and pairs in phi
    view_size, upright_view_size : texels a side of the table over omega_o, the latter of fabrics with upright tangents
    view_pairs : pairs in phi with which that table is made: grazing views ask for more than pixels can pay
    pooled_ratio : how many times the width 2 gamma of a lobe sigma must be for its Gaussian to be pooled
    """

    sharper: tuple[float, ...] = (150.0, 13.0, 4.5, 1.5, 0.55)
    shift: int = 0
    theta_count: int = 3
    phi_pairs: int = 4
    view_size: int = 49
    upright_view_size: int = 65
    view_pairs: int = 5
    pooled_ratio: tuple[float, float] = (0.7, 0.9)


SCHEDULES = {
    "draft": Schedule(sharper=(120.0, 8.0, 2.5), theta_count=2, phi_pairs=3, upright_view_size=49),
    "normal": Schedule(),
    "high": Schedule(
        sharper=(300.0, 22.0, 6.0, 2.2, 0.9),
        shift=2,
        theta_count=5,
        phi_pairs=6,
        view_size=97,
        upright_view_size=97,
        pooled_ratio=(0.6, 0.8),
    ),
}

BROAD_SHARPNESS = (6.0, 9.0)  # Gaussians broader than this are looked up at directions that are fixed to the surface
POOLED_SHARPNESS = (22.0, 30.0)  # Gaussians broader than this may be summed on the nodes of a narrow lobe,
NARROW_DEG = (6.2, 11.0)  # if gamma is at most this (and see Schedule.pooled_ratio)
SAME_NODES_RATIO = (2.2, 4.0)  # lobes of one yarn whose widths differ more than this cannot share nodes in theta
# How much finer the table over omega_o is at the horizon than at N. Flat tangents ask for it there, and upright ones, which
# from above show little of themselves, here; by the most upright tilt.
VIEW_RIM, UPRIGHT_DEG = (2.0, 0.7), (45.0, 75.0)
BLEND = np.log(1.1)  # half width in log sharpness of the change from one level to the next
BROAD_LOBE = 0.75  # radians^2, of 2 gamma^2: lobes broader than this ask for no fewer nodes, because W varies too
LINEN_LOBE = 0.088  # 2 gamma^2 of 12 degrees
CUT_SHARPNESS = 3.5  # added to the sharpness: the horizon keeps the variance of a broad Gaussian finite

# The share s of its distance from the mean that a node keeps when it stands for a little Gaussian, by n of the n x n
# rule and r = V / (V + 2 gamma^2), V the Gaussian's variance: least squares of the mass, mean and variance of the product
# of Gaussian and lobe over all places and directions of the lobe (docs/direct.md).
_R = (0.0, 0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 0.99, 1.0)
_KEPT = {
    1: (0.0,) * 14,
    2: (1.0, 0.983, 0.965, 0.931, 0.897, 0.864, 0.833, 0.803, 0.776, 0.750, 0.727, 0.715, 0.707, 0.704),
    3: (1.0, 1.0, 1.0, 1.0, 0.996, 0.981, 0.950, 0.912, 0.872, 0.834, 0.800, 0.784, 0.772, 0.769),
    4: (1.0, 1.0, 1.0, 1.0, 0.999, 0.996, 0.985, 0.959, 0.925, 0.887, 0.851, 0.835, 0.822, 0.819),
    5: (1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 0.997, 0.985, 0.956, 0.919, 0.882, 0.864, 0.850, 0.847),
    6: (1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 0.995, 0.976, 0.942, 0.904, 0.885, 0.870, 0.867),
}
# Least squares weigh the place of the product as much as its mass; where a Gaussian lights a narrow lobe alone, its mass is
# the radiance. Rules of four and of seven nodes move so many times as far from s = 1 (docs/direct.md); more nodes need not.
NEARER = {1: 2.0, 2: 2.0}


def smoothstep(low, high, x):
    """0 below low, 1 above high, smooth between."""
    t = np.clip((np.asarray(x, float) - low) / (high - low), 0.0, 1.0)
    return t * t * (3.0 - 2.0 * t)


def kept_share(level: int, sharpness: np.ndarray, gamma: np.ndarray, left: float = 1.0) -> np.ndarray:
    """s of `_KEPT` for a level of the ladder; `left`: share of the Gaussian's variance that the horizon leaves."""
    n = nodes_in_row(level)
    variance = left / (sharpness + CUT_SHARPNESS)
    r = variance / (variance + 2.0 * np.square(gamma))
    return 1.0 - NEARER.get(level, 1.0) * (1.0 - np.interp(r, _R, _KEPT[min(n, 6)])) * min(n, 6) / n


def upright(fabric: Fabric) -> float:
    """How upright (0..1) the most upright tangent is."""
    return float(smoothstep(*UPRIGHT_DEG, np.degrees(max(abs(t.tilt) for t in fabric.tangents))))


def view_rim(fabric: Fabric) -> float:
    """`rim` of glsl/direct/view.glsl."""
    return VIEW_RIM[0] + upright(fabric) * (VIEW_RIM[1] - VIEW_RIM[0])


def view_size(schedule: Schedule, fabric: Fabric) -> int:
    """Texels a side of the table over omega_o."""
    return schedule.upright_view_size if upright(fabric) > 0.0 else schedule.view_size


def pooled_lobes(fabric: Fabric) -> tuple[Lobes, Lobes]:
    """Which lobes of the two yarns are narrow enough to have nodes of their own, and by how much (0..1)."""

    def lobes(yarn: Yarn) -> Lobes:
        gammas = np.array([yarn.gamma_s_deg, yarn.gamma_v_deg])
        narrow = 1.0 - smoothstep(*NARROW_DEG, gammas.min())
        together = 1.0 - smoothstep(*SAME_NODES_RATIO, gammas.max() / gammas.min())
        shares = np.where(gammas == gammas.min(), narrow, narrow * together)
        return Lobes(*np.radians(gammas), *shares)

    return lobes(fabric.yarn[0]), lobes(fabric.yarn[1])


def pooled_share(schedule: Schedule, sharpness: np.ndarray, lobes: tuple[Lobes, Lobes]) -> np.ndarray:
    """How much [K] of each Gaussian the pooled nodes carry, in the lobes that are pooled."""
    widths = [lobe.width for lobe in lobes if max(lobe.share_s, lobe.share_v) > 0.0]
    if not widths:
        return np.zeros(len(sharpness))
    sigma = np.sqrt(2.0 / np.maximum(sharpness, 1e-9))
    broad = 1.0 - smoothstep(*POOLED_SHARPNESS, sharpness)
    return broad * smoothstep(*schedule.pooled_ratio, sigma / max(widths))


def broad_share(sharpness: np.ndarray) -> np.ndarray:
    """How much [K] of each Gaussian is looked up at a few directions (broad_nodes.py)."""
    return 1.0 - smoothstep(*BROAD_SHARPNESS, sharpness)


def _scale(pooled: float, lobes: tuple[Lobes, Lobes]) -> float:
    """How much sharper than for linen a Gaussian must be for the same level: the narrowest lobe that is not pooled decides.

    What is pooled in part counts in part.
    """
    broad = 1.0 / BROAD_LOBE
    logs = [
        (1.0 - pooled * share) * np.log(max(1.0 / (2.0 * gamma**2), broad)) + pooled * share * np.log(broad)
        for lobe in lobes
        for gamma, share in ((lobe.gamma_s, lobe.share_s), (lobe.gamma_v, lobe.share_v))
    ]
    return float(np.clip(np.sqrt(LINEN_LOBE * np.exp(max(logs))), 0.15, 4.0))


def _two_levels(height: float) -> list[tuple[int, float]]:
    """The levels below and above a height of the ladder, with their shares (sum 1)."""
    height = min(height, len(LADDER) - 1.0)
    low = int(height)
    return [(level, share) for level, share in ((low, 1.0 - height + low), (low + 1, height - low)) if share > 1e-4]


def levels(schedule: Schedule, sharpness: float, pooled: float, lobes: tuple[Lobes, Lobes]) -> list[tuple[int, float]]:
    """The level or the two levels of the ladder for one Gaussian, with their shares (sum 1).

    `pooled` is the Gaussian's `pooled_share`.
    """
    x, scale = np.log(max(sharpness, 1e-9)), np.log(_scale(pooled, lobes))
    # A single node sees the lobe exactly; it is W, which varies alike in all fabrics, that asks for more.
    edges = np.log(schedule.sharper) + scale
    edges[0] -= 0.25 * scale
    edges[1] -= 0.4 * pooled  # the pooled nodes carry what varies most
    height = float((1.0 - smoothstep(edges - BLEND, edges + BLEND, x)).sum())
    return _two_levels(height + schedule.shift)
