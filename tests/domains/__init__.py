"""Where each parameter of a GLSL function lives: by symbol, with the corners that must be tried.

A domain is a function (rng, count) -> values; `between(low, high, corners...)` and its kin make them. DOMAINS holds for
every GLSL file. The module of a GLSL folder (sg.py for glsl/sg) may define DOMAINS of its own, SPECIAL, which overrides
the domain of one parameter of one function, JOINT, (rng, count) -> {parameter: values} of those parameters of a function
that only make sense together, and TOLERANCE, the allowed difference of one function, with its reason.
"""

import numpy as np

RTOL, ATOL = 3e-5, 1e-6
DEG = np.pi / 180


def _with_corners(values, corners, rng):
    corners = np.asarray(corners, float)
    if len(corners):
        chosen = rng.random(len(values)) < 0.25
        values[chosen] = corners[rng.integers(0, len(corners), chosen.sum())]
    return values


def between(low, high, *corners):
    """Uniform in [low, high], the ends and the corners often."""
    return lambda rng, count: _with_corners(rng.uniform(low, high, count), [low, high, *corners], rng)


def log_between(low, high, *corners):
    """Uniform in the logarithm."""
    return lambda rng, count: _with_corners(
        np.exp(rng.uniform(np.log(low), np.log(high), count)), [low, high, *corners], rng
    )


def choice(*values):
    """One of some values."""
    return lambda rng, count: np.asarray(values)[rng.integers(0, len(values), count)]


AXES = np.concatenate([np.eye(3), -np.eye(3)])


def directions(rng, count, tilt=1e-3):
    """Unit vectors; a quarter of them a thousandth from an axis, where poles and horizons are."""
    v = rng.normal(size=(count, 3))
    near = rng.random(count) < 0.25
    v[near] = AXES[rng.integers(0, 6, near.sum())] + rng.normal(scale=tilt, size=(near.sum(), 3))
    return v / np.linalg.norm(v, axis=1, keepdims=True)


def directions_and_axes(rng, count):
    """Unit vectors, the six axes themselves among them."""
    v = directions(rng, count)
    exact = rng.random(count) < 0.1
    v[exact] = AXES[rng.integers(0, 6, exact.sum())]
    return v


def vectors(scale):
    """Vectors of any length up to about `scale`."""
    return lambda rng, count: rng.normal(size=(count, 3)) * scale * rng.random((count, 1))


def pairs(rng, count):
    """Two-component vectors, as projections of unit vectors are."""
    return directions(rng, count)[:, 1:]


def above_horizon(rng, count):
    """Unit vectors with z > 0, grazing ones often."""
    v = directions(rng, count)
    v[:, 2] = np.abs(v[:, 2])
    return v


GAMMA = between(0.5 * DEG, 60 * DEG, 2.5 * DEG, 5 * DEG)
DOMAINS = {
    "eta": between(1.05, 3.0, 1.345, 1.539),
    "F_0": between(0.0, 0.25),
    "cos_theta": between(0.0, 1.0),
    "k_d": between(0.0, 1.0),
    "gamma": GAMMA,
    "gamma_s": GAMMA,
    "gamma_v": GAMMA,
    "sigma": between(1 * DEG, 90 * DEG, 20 * DEG),
    "omega": directions_and_axes,
    "omega_i": directions,
    "omega_o": directions,
    "N": directions_and_axes,
    "yarn": choice(0, 1),
    "projected_i": pairs,
    "projected_o": pairs,
}
