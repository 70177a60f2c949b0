"""Domains of glsl/simulate: metres, seconds, kilograms of a real cloth, and the degenerate corners."""

import numpy as np

from . import between, choice, directions, log_between, vectors


def _points(rng, count):
    return rng.normal(size=(count, 3))


def _cells(rng, count):
    return rng.integers(-2000, 2000, (count, 3)).astype(float)


def _half_sizes(rng, count):
    return rng.uniform(0.2, 1.5, (count, 3))


def _pivots(rng, count):
    return np.column_stack([np.exp(rng.uniform(np.log(1e2), np.log(1e5), count)), rng.normal(size=count) * 1e-6])


def _far_or_near(rng, count):
    """Vectors from micrometres to decimetres."""
    return directions(rng, count) * np.exp(rng.uniform(np.log(1e-6), np.log(0.1), (count, 1)))


# 1/kg: a vertex of 0.04 to 0.3 kg/m^2 cloth at 5 to 20 mm spacing; 0 = pinned.
_inverse_mass = log_between(8e3, 1e6, 0.0)

DOMAINS = {
    "p": _points,
    "p_0": _points,
    "p_1": _points,
    "p_2": _points,
    "w_0": _inverse_mass,
    "w_1": _inverse_mass,
    "w_2": _inverse_mass,
    "rest": log_between(5e-3, 2e-2),
    "alpha_h2": log_between(1.0, 1e7),
    "diagonal": log_between(2e4, 2e6),
    # The tridiagonal matrix is diagonally dominant: |off| is at most half the diagonal.
    "off": between(-8e3, 8e3, 0.0),
    "C": between(-1e-3, 1e-3, 0.0),
    "before": _pivots,
    "eliminated": _pivots,
    "lambda_next": between(-1e-6, 1e-6, 0.0),
    "normal": directions,
    "offset": between(-2.0, 2.0, 0.0),
    "center": vectors(0.5),
    "radius": between(0.0, 0.2),
    "half_size": _half_sizes,
    "axes": _half_sizes,
    "slide": _far_or_near,
    "push": log_between(1e-7, 1e-2),
    "mu": between(0.0, 1.0),
    "v_rel": vectors(5.0),
    "S": _far_or_near,
    "C_n": between(0.0, 2.0),
    "C_t": between(0.0, 1.0),
    "F": vectors(1e-3),
    "m": log_between(1e-7, 1e-3),
    "h": log_between(1e-4, 1e-2),
    "t": between(0.0, 60.0),
    "drift": vectors(3.0),
    "g": between(0.0, 1.0),
    "cell": _cells,
    "size": choice(256, 4096, 65536),
    "gap": between(0.5, 3.0),
}


def points_of_ellipsoids(rng, count):
    """Points about their middles; a tenth is the very middle."""
    center = rng.normal(scale=0.5, size=(count, 3))
    p = center + rng.normal(size=(count, 3))
    p[::10] = center[::10]
    return {"p": p, "center": center}


def particles(rng, count):
    """Two particles; a tenth lie in one place."""
    p = rng.normal(size=(count, 3))
    other = rng.normal(size=(count, 3))
    other[::10] = p[::10]
    return {"p_0": p, "p_1": other}


JOINT = {"d_ellipsoid": points_of_ellipsoids, "part": particles}
SPECIAL = {("d_sphere", "radius"): between(0.05, 1.0)}
TOLERANCE = {
    # One part in 6e-8 of the phase, which reaches a thousand radians.
    "gust": (1e-3, 3e-4),
    # Points at metres from the origin, rounded to float32, leave the distance 1e-7 m; near its zero that is all there is.
    "d_plane": (3e-5, 2e-6),
    # The gradient of a point a micrometre from an edge turns with the last bit of its position.
    "d_box": (3e-4, 1e-4),
}
