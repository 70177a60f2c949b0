"""Domains of glsl/core."""

import numpy as np

from . import above_horizon, between, directions, vectors


def weights(rng, count):
    """Barycentric coordinates."""
    return rng.dirichlet((1.0, 1.0, 1.0), count)


def fixed(corner):
    """A corner that shakes a little, so that every triangle has an area."""
    return lambda rng, count: np.asarray(corner) + rng.uniform(-0.2, 0.2, (count, 3))


DOMAINS = {
    "a": fixed((1.0, 0.0, 0.0)),
    "b": fixed((0.0, 1.0, 0.0)),
    "c": fixed((0.0, 0.0, 1.0)),
    "n_a": directions,
    "n_b": directions,
    "n_c": directions,
    "weights": weights,
}
SPECIAL = {
    ("barycentric", "x"): vectors(1.0),
    ("lifted", "x"): vectors(1.0),
    ("facing_normal", "least"): between(0.02, 0.1),
    ("pow5", "x"): between(-2.0, 2.0, 0.0, 1.0),
    ("orthogonal_part", "v"): vectors(1.0),
    ("mirrored_direction", "d"): directions,
    ("mirrored_direction", "N_g"): directions,
    # At the poles themselves u has no value.
    ("uv_from_direction", "omega"): directions,
    ("to_disk", "omega"): above_horizon,
    ("from_disk", "p"): lambda rng, count: rng.uniform(-1.2, 1.2, (count, 2)),
    ("erf", "x"): between(-8.0, 8.0, 0.0, -1.0, 1.0),
}
TOLERANCE = {
    # The part across omega_o is what is left of N; next to -omega_o a thousandth of it, with as many digits fewer.
    "facing_normal": (3e-5, 1e-3),
    # Taking away the part of v along N loses |v| / |x| in digits, at most 1e4 before the fallback.
    "orthogonal_part": (3e-5, 1e-3),
}
