"""Domains of glsl/woven."""

import numpy as np

from . import above_horizon, between, choice, directions

ROUGHNESS = between(0.05, 1.0, 0.1, 0.3, 0.5)


def below_horizon(rng, count):
    """Unit vectors of both sides, most of them with z < 0."""
    v = directions(rng, count)
    flip = rng.random(count) < 0.9
    v[flip, 2] = -np.abs(v[flip, 2])
    return v


def off_horizon(domain):
    """The unit vectors of a domain, kept 0.01 from the horizon, where a sum of two such cosines divides."""

    def draw(rng, count):
        v = domain(rng, count)
        v[:, 2] = np.where(np.abs(v[:, 2]) < 0.01, np.where(v[:, 2] < 0, -0.01, 0.01), v[:, 2])
        return v / np.linalg.norm(v, axis=1, keepdims=True)

    return draw


DOMAINS = {
    "roughness": ROUGHNESS,
    "roughness_p": ROUGHNESS,
    "eta_1": choice(1.0, 1.33, 1.5),
    "eta_2": choice(1.1, 1.25, 1.54, 2.0),
    "rho": between(0.0, 1.0),
    "k_a": between(0.0, 1.0),
    "k_t": between(0.0, 1.0),
    "k": between(0.0, 1.0),
    "diffuse": between(0.0, 1.0),
    "tau": lambda rng, count: rng.uniform(0, 3, (count, 3)),
    "h": above_horizon,
    "cos_lh": between(0.0, 1.0),
    "open": between(0.0, 1.0),
    "hole": between(0.0, 1.0),
    "mean": between(0.05, 0.95),
    "x": between(0.0, 10.0),
    "R": between(0.0, 1.0),
    "T": lambda rng, count: rng.uniform(0, 1, (count, 3)),
    "albedo": lambda rng, count: rng.uniform(0, 1, (count, 3)),
}
SPECIAL = {
    **{
        (name, "omega_i"): off_horizon(above_horizon)
        for name in ("f_GGX", "f_straight", "f_yarn", "f_through", "f_lambert", "h_t")
    },
    **{
        (name, "omega_o"): off_horizon(below_horizon)
        for name in ("f_GGX", "f_straight", "f_yarn", "f_through", "f_lambert", "h_t")
    },
    **{
        (name, "omega"): off_horizon(directions)
        for name in ("T_open", "T_sheet", "T_sheet_at", "T_straight", "T_lambert", "R_sheet", "R_beside", "G_1_smith")
    },
    **{(name, o): off_horizon(directions) for name in ("covered", "absorption") for o in ("omega_i", "omega_o")},
}
TOLERANCE = {
    # 1 - F at the critical angle goes as the root of a difference, and h_t for near indices is a difference of near
    # vectors: either loses three digits of the seven.
    "f_GGX": (3e-4, 1e-6),
    "f_yarn": (3e-4, 1e-6),
    "f_through": (3e-4, 1e-6),
    # Rounding of q is divided by the cosine, 0.01 at least.
    "T_open": (3e-5, 1e-5),
    "covered": (3e-5, 1e-5),
    "T_sheet": (3e-5, 1e-5),
    "T_sheet_at": (6e-4, 6e-4),
    "T_straight": (3e-5, 1e-5),
    # Where nearly all is open 1 - holes is a difference of near numbers.
    "T_lambert": (3e-5, 1e-5),
    "f_lambert": (3e-5, 1e-5),
    "R_sheet": (3e-5, 1e-5),
    "R_beside": (3e-5, 3e-5),
}
