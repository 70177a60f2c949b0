"""Domains of glsl/core."""

import numpy as np

from . import above_horizon, between, directions, log_between, vectors


def weights(rng, count):
    """Barycentric coordinates."""
    return rng.dirichlet((1.0, 1.0, 1.0), count)


def fixed(corner):
    """A corner that shakes a little, so that every triangle has an area."""
    return lambda rng, count: np.asarray(corner) + rng.uniform(-0.2, 0.2, (count, 3))


def plane_vectors(rng, count):
    """Vectors of a plane, of very different lengths."""
    return rng.normal(size=(count, 2)) * 10.0 ** rng.uniform(-2.0, 2.0, (count, 1))


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
    # Farther than the twentieth part from the edge of the plane, float32 keeps five digits of the way.
    ("place_step", "d"): lambda rng, count: directions(rng, count) * rng.uniform(0.5, 2.0, (count, 1)),
    ("place_step", "change"): vectors(0.01),
    ("place_step", "n"): directions,
    ("place_step", "t"): between(0.01, 10.0),
    ("uv_step", "way"): vectors(0.01),
    ("uv_step", "to_b"): fixed((1.0, 0.0, 0.0)),
    ("uv_step", "to_c"): fixed((0.0, 1.0, 0.0)),
    ("uv_step", "uv_b"): plane_vectors,
    ("uv_step", "uv_c"): plane_vectors,
    ("taps_and_level", "x"): plane_vectors,
    ("taps_and_level", "y"): plane_vectors,
    ("taps_and_level", "most"): between(1.0, 8.0),
    # Mip levels of which no rounding makes another version.
    ("level_number", "level"): lambda rng, count: (rng.integers(0, 97, count) + 0.4) / 8.0,
    ("level_number", "steps"): lambda rng, count: np.tile((2.0, 6.0, 24.0), (count, 1)),
    ("level_number", "choice"): lambda rng, count: (rng.integers(0, 16, count) + 0.5) / 16.0,
    ("level_of_number", "number"): lambda rng, count: rng.integers(0, 24, count).astype(float),
    ("level_of_number", "steps"): lambda rng, count: np.tile((2.0, 6.0, 24.0), (count, 1)),
    ("place_in", "rect"): lambda rng, count: rng.uniform(0.0, 0.5, (count, 4)),
    ("place_in", "place"): lambda rng, count: (rng.integers(-40, 40, (count, 2)) + 0.5) / 8.0,
    ("lean", "omega"): above_horizon,
    ("relief_way", "omega"): above_horizon,
    ("with_mean", "value"): lambda rng, count: rng.uniform(0.0, 10.0, (count, 4)),
    ("with_mean", "mean"): lambda rng, count: rng.uniform(0.0, 2.0, (count, 4)),
    ("with_mean", "wanted"): between(0.2, 2.0),
    ("facing_normal", "least"): between(0.02, 0.1),
    ("largest", "v"): vectors(1.0),
    ("in_texel", "middle"): directions,
    ("in_texel", "solid_angle"): log_between(1e-6, 0.3),
    ("in_texel", "at"): lambda rng, count: rng.uniform(-0.5, 0.5, (count, 2)),
    ("pow5", "x"): between(-2.0, 2.0, 0.0, 1.0),
    ("mirrored_direction", "d"): directions,
    ("mirrored_direction", "N_g"): directions,
    # At the poles themselves u has no value.
    ("uv_from_direction", "omega"): directions,
    ("to_disk", "omega"): above_horizon,
    ("from_disk", "p"): lambda rng, count: rng.uniform(-1.2, 1.2, (count, 2)),
    ("erf_inverse", "y"): between(-0.9999, 0.9999, 0.0, -0.5, 0.99),
    ("erf", "x"): between(-8.0, 8.0, 0.0, -1.0, 1.0),
}


def vectors_and_normals(rng, count):
    """Any vector and a normal; a tenth of them are along it or zero."""
    n, v = directions(rng, count), rng.normal(size=(count, 3))
    v[::10] = n[::10] * np.linspace(-2.0, 2.0, len(n[::10]))[:, None]
    v[5] = 0.0
    return {"v": v, "N": n}


JOINT = {"orthogonal_part": vectors_and_normals}
TOLERANCE = {
    "erf_inverse": (3e-4, 1e-6),  # 1 - 1e-4 in single precision has three digits of its distance from 1
    # The part across omega_o is what is left of N; next to -omega_o a thousandth of it, with as many digits fewer.
    "facing_normal": (3e-5, 1e-3),
    # Taking away the part of v along N loses |v| / |x| in digits, at most 1e4 before the fallback.
    "orthogonal_part": (3e-5, 1e-3),
}
