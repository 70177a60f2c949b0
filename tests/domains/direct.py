"""Domains of glsl/direct."""

import numpy as np

from glcloth.twins.slots import ANGLE_SERIES

from . import DEG, above_horizon, between, directions, log_between

HALF = np.pi / 2


def four(low, high, *corners):
    """Four values of one domain, the corners often."""
    one = between(low, high, *corners)
    return lambda rng, count: one(rng, 4 * count).reshape(count, 4)


def mask_series(rng, count):
    """The coefficients of g for sigma from 1 to 30 degrees; beyond, see TOLERANCE."""
    sigma = np.exp(rng.uniform(np.log(1 * DEG), np.log(30 * DEG), count))
    return -ANGLE_SERIES / (sigma[:, None] ** 2 * np.log(2))


def off_zenith(rng, count):
    """Directions whose azimuth float32 still knows."""
    v = directions(rng, count)
    v[:, :2] += np.where(np.hypot(v[:, 0], v[:, 1]) < 1e-2, 1e-2, 0.0)[:, None]
    return v / np.linalg.norm(v, axis=1, keepdims=True)


def horizontal(rng, count):
    """Unit vectors in the plane."""
    angle = rng.uniform(-np.pi, np.pi, count)
    return np.stack([np.cos(angle), np.sin(angle)], -1)


def two_directions(rng, count):
    """omega_i and omega_o as four tangents see them, above their horizons."""
    theta_i, theta_o, phi_i, phi_o = rng.uniform(-HALF, HALF, (4, count, 4))
    return {
        "t": np.sin(theta_i),
        "cos_theta_i": np.cos(theta_i),
        "cos_phi_i": np.cos(phi_i),
        "cos_phi_d": np.cos(phi_i - phi_o),
        "sin_theta_o": np.sin(theta_o),
        "cos_theta_o": np.cos(theta_o),
        "cos_phi_o": np.cos(phi_o),
    }


def azimuth_of_node(rng, count):
    """The cosine and sine of an azimuth on the lit side of a cylinder."""
    phi = rng.uniform(0, HALF, count)
    return {"cos_phi": np.cos(phi), "sin_phi": np.sin(phi)}


JOINT = {"scatter_slots": two_directions, "scatter_pair": azimuth_of_node}
DOMAINS = {
    "rim": between(0.5, 3.0, 1.0),
    "p": lambda rng, count: rng.uniform(-1.2, 1.2, (count, 2)),
    "angle": between(0.0, np.pi, HALF),
    "width": log_between(1.5e-3, 1.5),
    "xi": off_zenith,
    "node": directions,
    "e": horizontal,
    "mu": between(-HALF, HALF, 0.0),
    "low": between(-HALF, 0.0),
    "high": between(0.0, HALF),
    "sin_theta": between(-1.0, 1.0, 0.0),
    "cos_theta": between(0.0, 1.0),
    "cos_angle": four(-1.0, 1.0, 0.0, 1.5),  # rounding brings it above 1 at a tangent's pole
    "series": mask_series,
    "x": four(0.0, 1.0),
    "y": four(-1.0, 1.0, 0.0),
    "z": four(-1.0, 1.0, 0.0),
    "F_0": four(0.0, 0.25),
    "cos_theta_d": four(0.0, 1.0),
    "cos_half_phi_d": four(0.0, 1.0),
}
SPECIAL = {
    ("to_view", "omega"): above_horizon,
    ("tangent_slots", "along"): four(-1.0, 1.0),
    ("tangent_slots", "z"): between(-1.0, 1.0),
    ("tangent_slots", "cos_tilt"): four(0.0, 1.0),
    ("tangent_slots", "sin_tilt"): four(-1.0, 1.0),
    ("theta_slots", "t"): four(-1.0, 1.0, 0.0),
    ("lobe_slots", "theta_i"): four(-HALF, HALF),
    ("lobe_slots", "start"): four(-3.0, 3.0),
    ("lobe_slots", "slope"): four(0.0, 3.0),
    ("scatter_pair", "phi_o"): horizontal,
    ("scatter_pair", "F_0"): between(0.0, 0.25),
    ("scatter_pair", "cos_theta_d"): between(0.0, 1.0),
    ("column_of_lobe", "width"): log_between(0.5 * DEG, 1.5),
    ("twice_atan", "y"): four(-1.0, 1.0, 0.0, 0.01),
    ("sin_limit", "cos_tilt"): between(1e-3, 1.0),
    ("sin_limit", "sin_tilt"): between(-1.0, 1.0, 0.0),
}
TOLERANCE = {
    # Differences of arctangents of up to 1e5 in the denominator; a column is 1 / 63.
    "column_of": (1e-5, 2e-4),
    "column_of_lobe": (1e-5, 2e-4),
    # The fitted end of the series: 1e-4 for sigma up to 30 degrees. And 1 - cos(angle) has a rounding of 6e-8, over
    # sigma^2 = 3e-4 for one degree.
    "g_of_cos": (1e-3, 4e-4),
    # M by that.
    "scatter_pair": (1e-3, 4e-4),
    "scatter_slots": (1e-3, 4e-4),
    # The polynomial is off by 4e-6, and by 2e-5 of small angles.
    "twice_atan": (3e-5, 5e-6),
    # Where cos^2(theta) is held above 1e-7.
    "theta_slots": (3e-5, 4e-4),
    # The root of 1 - q^2 near its end.
    "sin_limit": (3e-5, 1e-3),
}
