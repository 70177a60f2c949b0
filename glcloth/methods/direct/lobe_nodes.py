"""Quadrature nodes in theta on a tangent's narrow lobes, tabulated by theta_o.   [own]

A lobe is g_u(theta_h; 0, gamma), a Gaussian of theta_i of width 2 gamma about -theta_o. The surface and the volume lobe
of a yarn share their nodes: those of a Gauss rule of a mixture of the two, times what the cylinder of a tilted tangent
has above both horizons. Each lobe then has the weights that integrate polynomials exactly.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from ...gpu.layout import shared
from ...twins.pool import lobe_at_column, sin_limit
from .gauss import nodes_and_weights, recurrence

COLUMNS = int(shared("inputs/methods/direct_lobes.glsl")[0]["LOBE_COLUMNS"])  # of a table, over theta_o
HALF = np.pi / 2
NARROW_SHARE = 0.8  # of the narrower lobe in the mixture whose Gauss nodes both lobes use
_X, _W = np.polynomial.legendre.leggauss(12)


@dataclass(frozen=True)
class Lobes:
    """The two lobes of a yarn as the pooled nodes see them: widths in radians, and the share 0..1 that is pooled."""

    gamma_s: float
    gamma_v: float
    share_s: float
    share_v: float

    @property
    def width(self) -> float:
        """The width in theta_i of the widest pooled lobe; a lobe that is hardly pooled hardly counts."""
        narrow, wide = sorted([(self.gamma_s, self.share_s), (self.gamma_v, self.share_v)])
        relative = min(wide[1] / max(narrow[1], 1e-9), 1.0)
        return 2.0 * narrow[0] * (wide[0] / narrow[0]) ** relative


def ends(tilt: float) -> tuple[float, float]:
    """The ends of theta_i above both the horizon of N and the tangent's own."""
    return -HALF - min(tilt, 0.0), HALF - max(tilt, 0.0)


def lobe_table(tilts: np.ndarray, lobes: Lobes, count: int) -> np.ndarray:
    """Nodes [tangents, count, COLUMNS, 4] float32: (theta_i + theta_o, surface weight, volume weight, 0).

    Weights hold the lobe, without its factor sin(phi_max), which the shader's rule in phi brings.

    Parameters
    ----------
    tilts : [tangents] radians
    count : nodes in theta
    """
    # The table of a tangent tilted the other way is the same, mirrored.
    tilts = np.asarray(tilts, float)
    unique, inverse = np.unique(np.abs(tilts), return_inverse=True)
    tables = _tables(tuple(unique.tolist()), lobes, count)[inverse]
    mirrored = tables[:, ::-1, ::-1] * np.array([-1.0, 1.0, 1.0, 1.0])
    return np.where((tilts < 0)[:, None, None, None], mirrored, tables).astype(np.float32)


@lru_cache(8)
def _tables(of_tilts: tuple[float, ...], lobes: Lobes, count: int) -> np.ndarray:
    tilts = np.array(of_tilts)
    width = lobes.width
    low = np.full(len(tilts), -HALF)[:, None]
    high = (HALF - tilts)[:, None]
    column = np.linspace(0, 1, COLUMNS)
    mu = lobe_at_column(np.broadcast_to(column, (len(tilts), COLUMNS)), low, high, width)[..., None]
    near = np.clip(mu, low[..., None], high[..., None])
    narrow = 2 * min(lobes.gamma_s, lobes.gamma_v)
    # Panels: dense where the narrow lobe is.
    marks = np.array([-3.5 * width, -1.2 * narrow, 0.0, 1.2 * narrow, 3.5 * width])
    marks[0], marks[-1] = min(marks[0], -2 * narrow), max(marks[-1], 2 * narrow)
    edges = np.clip(near + marks, low[..., None], high[..., None])
    half = 0.5 * np.diff(edges)[..., None]
    theta = (0.5 * (edges[..., 1:] + edges[..., :-1])[..., None] + half * _X).reshape(*mu.shape[:2], -1)
    # A panel without length has no points to tell apart; a hair keeps the arithmetic finite and weighs nothing.
    w = np.maximum((half * _W).reshape(theta.shape), 0.0)
    w = w * sin_limit(np.sin(theta), np.cos(theta), np.cos(tilts)[:, None, None], np.sin(tilts)[:, None, None])

    def lobe(gamma):
        x = (theta - mu) / (2 * gamma)
        x_near = (near - mu) / (2 * gamma)
        return w * np.exp(x_near**2 - x**2), np.exp(-(x_near**2)) / (np.sqrt(np.pi) * gamma)

    (surface, scale_s), (volume, scale_v) = lobe(lobes.gamma_s), lobe(lobes.gamma_v)
    shares = (lobes.share_s, lobes.share_v)
    wide_share = (1 - NARROW_SHARE) * min(shares) / max(max(shares), 1e-9)
    parts = (surface, volume) if lobes.gamma_s <= lobes.gamma_v else (volume, surface)
    normal = [part / np.maximum(part.sum(-1, keepdims=True), 1e-280) for part in parts]
    mixture = NARROW_SHARE * normal[0] + wide_share * normal[1] + 1e-30
    x = (theta - near) / narrow
    nodes, _ = nodes_and_weights(*recurrence(x, mixture, count))
    out = np.zeros((len(tilts), count, COLUMNS, 4))
    for i in range(count):
        others = [j for j in range(count) if j != i]
        basis = np.ones_like(x)
        for j in others:
            gap = nodes[..., i, None] - nodes[..., j, None]
            basis = basis * (x - nodes[..., j, None]) / np.where(np.abs(gap) < 1e-9, 1e-9, gap)
        out[:, i, :, 0] = nodes[..., i] * narrow + (near - mu)[..., 0]
        out[:, i, :, 1] = lobes.share_s * (surface * basis).sum(-1) * scale_s[..., 0]
        out[:, i, :, 2] = lobes.share_v * (volume * basis).sum(-1) * scale_v[..., 0]
    return out
