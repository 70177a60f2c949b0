"""Twin of glsl/trace/spread.glsl: directions through a sheet, drawn from its lobes, in float64."""

import numpy as np

from .math import largest
from .random import cosine_direction, facet_direction
from .sheet import T_open, absorption


def straight_parts(omega_o, k_a, k_t, tau, rho):
    """Light that passes straight on [..., 4]: three through the yarns, one through the holes.   [own]"""
    open_ = T_open(omega_o, rho)
    yarns = ((1 - open_) * k_t)[..., None] * absorption(omega_o, omega_o, tau)
    return np.concatenate([yarns, (k_a * open_)[..., None]], -1)


def hole_chance(parts):
    """The chance with which a hole is drawn, of such parts [..., 4].   [own]"""
    return parts[..., 3] / np.maximum(parts[..., 3] + largest(parts[..., :3]), 1e-12)


def drawn_weight(parts, hole):
    """The weight [..., 3] of a ray drawn through a hole (1) or the yarns (0).   [own]"""
    chance = hole_chance(parts)[..., None]
    return np.where(
        np.asarray(hole)[..., None] == 1,
        parts[..., 3:] / np.maximum(chance, 1e-12) * np.ones(3),
        parts[..., :3] / np.maximum(1 - chance, 1e-12),
    )


def yarn_direction(omega_o, u, part, roughness, eta_1, eta_2, diffuse, roughness_p):
    """A direction [..., 3] through the yarns by three numbers from 0 to 1, u [..., 2] and `part`.   [own]"""
    omega_o = np.asarray(omega_o, float)
    h = facet_direction(u, roughness_p)
    straight = (2 * (omega_o * h).sum(-1, keepdims=True) * h - omega_o) * [1, 1, -1]
    # Snell's law in the plane of omega_o and the facet: across the facet the sine grows by eta_1 / eta_2.
    h = facet_direction(u, roughness)
    along = (omega_o * h).sum(-1, keepdims=True)
    across = -(omega_o - along * h) * (np.asarray(eta_1) / eta_2)[..., None]
    rest = 1 - (across**2).sum(-1, keepdims=True)
    bent = np.where(rest >= 0, across - np.sqrt(np.maximum(rest, 0)) * h, 0.0)
    part, diffuse = np.asarray(part)[..., None], np.asarray(diffuse)[..., None]
    d = np.where(part < 0.5, straight, np.where(part < 0.5 + 0.5 * diffuse, -cosine_direction(u), bent))
    return np.where(d[..., 2:] < 0, d, -omega_o)
