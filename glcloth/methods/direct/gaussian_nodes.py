"""Quadrature nodes of a spherical Gaussian cut by the horizon, tabulated by the height of its axis.   [own]

In the Gaussian's frame a direction is sin(th) u + cos(th) (sin(ph) e + cos(ph) N), e the azimuth of its axis, u = N x e.
The horizon is exactly |ph| = pi / 2 whatever th is, and the Gaussian times the solid angle separates:
cos(th) exp(kappa (cos(th) - 1)) in th, exp(kappa cos(th) (cos(ph - angle) - 1)) in ph, `angle` from N to the axis.
So exact Gauss rules of the cut Gaussian are rows of one-dimensional rules, at any sharpness and also for axes below
the horizon.
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from ...gpu.layout import shared
from ...twins.node import angle_at_column, column_width
from .gauss import nodes_and_weights, polynomial, recurrence

# Columns of a table, over the angle between N and the axis.
COLUMNS = int(shared("inputs/methods/direct.glsl")[0]["NODE_COLUMNS"])
_X, _W = np.polynomial.legendre.leggauss(64)
HALF = np.pi / 2

# How many nodes in ph each row of th has, from coarse to fine. Outer rows weigh little and have one or two fewer; the
# inner ones make up for what those miss (see `_row_rules`). (2, 3, 2) is the seven-point rule of degree 5.
LADDER = (
    (1,),
    (2, 2),
    (2, 3, 2),
    (3, 5, 3),
    (3, 5, 5, 3),
    (4, 6, 6, 4),
    (5, 6, 6, 6, 5),
    (6, 7, 7, 7, 7, 6),
    (7, 8, 8, 8, 8, 8, 7),
)


def nodes_in_row(level: int) -> int:
    """The n of the n x n rule that a level of the ladder resembles."""
    return min(len(LADDER[level]), max(LADDER[level]))


def node_count(level: int) -> int:
    """Nodes of a level."""
    return sum(LADDER[level])


MOST_CUT = 0.64  # of its variance: half a Gaussian has lost as much
STEP = np.log(1.3)  # between the sharpnesses of the grid of tables
SUN = 1e9  # sharpness that stands for a point


def gaussian_table(sharpness: float, level: int) -> np.ndarray:
    """Nodes [node_count + 1, COLUMNS, 4] float32 of a Gaussian for axes from the zenith to the nadir.

    A node is (a, b, c, share of the mass) with omega = a u + b v + c xi, v = d xi / d angle. The last row is the mean
    direction and the logarithm of the mass; its a is 0, and in that place stands the share of the variance along v, at
    most MOST_CUT, that the horizon takes. Interpolated between the sharpnesses of a grid, so that no edit of a light
    computes a rule; in units of the Gaussian's width the rules change slowly.
    """
    place = np.log(max(sharpness, 1e-2)) / STEP
    i = int(np.floor(place))
    f = place - i
    table = (1 - f) * _cell(i, level) + f * _cell(i + 1, level)
    table[..., 2] = 1.0 - table[..., 2] / (sharpness + 1.0)
    table[..., :2] /= np.sqrt(sharpness + 1.0)
    # Interpolation leaves the sphere; the shader takes arcsines and roots of 1 - x^2.
    table[..., :3] /= np.linalg.norm(table[..., :3], axis=-1, keepdims=True)
    table[-1, :, 3] -= np.log(sharpness + 1.0)
    table[-1, :, 0] = _cut(table[:-1])
    return table.astype(np.float32)


def _cut(nodes: np.ndarray) -> np.ndarray:
    """How much less the nodes [n, COLUMNS, 4] vary along v than along u, as a share: 0 to MOST_CUT. One node says nothing."""
    if len(nodes) == 1:
        return np.zeros(COLUMNS)
    share = nodes[..., 3]
    along_u, along_v = ((share * (x - (share * x).sum(0)) ** 2).sum(0) for x in (nodes[..., 0], nodes[..., 1]))
    return np.clip(1.0 - along_v / along_u, 0.0, MOST_CUT)


def warm(level: int, low: float, high: float) -> None:
    """Compute the tables that `gaussian_table` interpolates for sharpnesses from low to high."""
    for i in range(int(np.floor(np.log(max(low, 1e-2)) / STEP)), int(np.floor(np.log(high) / STEP)) + 2):
        _cell(i, level)


@lru_cache(2048)
def _cell(i: int, level: int) -> np.ndarray:
    """Table number i of the grid in units of the Gaussian's width: (a s, b s, (1 - c) s^2, share), s^2 = sharpness + 1."""
    k = float(np.exp(i * STEP))
    table = exact_table(k, level)
    table[..., :2] *= np.sqrt(k + 1.0)
    table[..., 2] = (1.0 - table[..., 2]) * (k + 1.0)
    table[-1, :, 3] += np.log(k + 1.0)
    table.setflags(write=False)
    return table


def exact_table(sharpness: float, level: int) -> np.ndarray:
    """What `gaussian_table` interpolates, at one sharpness, float64."""
    rows = LADDER[level]
    k = float(sharpness)
    angle = angle_at_column(np.linspace(0, 1, COLUMNS), column_width(k))
    th, w_th = _th_rule(k, len(rows))
    # Rows of th and -th are equal.
    half = (len(rows) + 1) // 2
    nodes, logs = _row_rules(k, angle, th[:half], w_th[:half], rows[:half], len(rows))
    mirror = [*range(half), *range(len(rows) - half - 1, -1, -1)]
    columns = []
    for i, j in enumerate(mirror):
        sin_th, cos_th = np.sin(th[i]), np.cos(th[i])
        for n in range(rows[i]):
            turn = nodes[j][:, n] - angle
            columns.append((np.full(COLUMNS, sin_th), cos_th * np.sin(turn), cos_th * np.cos(turn), logs[j][:, n]))
    a, b, c, log_w = (np.array(column) for column in zip(*columns, strict=True))
    top = log_w.max(0)
    weight = np.exp(log_w - top)
    mass = weight.sum(0)
    share = weight / mass
    mean = np.stack([(share * v).sum(0) for v in (a, b, c)], -1)
    mean /= np.linalg.norm(mean, axis=-1, keepdims=True)
    table = np.zeros((len(a) + 1, COLUMNS, 4))
    table[:-1, :, 0], table[:-1, :, 1], table[:-1, :, 2], table[:-1, :, 3] = a, b, c, share
    table[-1, :, :3] = mean
    table[-1, :, 3] = np.maximum(top + np.log(mass), -80.0)
    return table


SKY_SHARPNESS = 1.5  # of the Gaussian about N whose rule the sky's nodes are


@lru_cache
def sky_nodes(level: int) -> np.ndarray:
    """Directions above the horizon, surface frame, and solid angles: [node_count, 4] for light that is broad.

    The rule of a Gaussian about N, divided by the Gaussian. Its rows lie diagonally to the yarns.
    """
    rule = exact_table(SKY_SHARPNESS, level)[:-1, 0]
    mass = np.exp(exact_table(SKY_SHARPNESS, level)[-1, 0, 3])
    a, b, c, share = rule.T
    diagonal = np.sqrt(0.5)
    omega = np.stack([diagonal * (b - a), diagonal * (a + b), c], -1)
    return np.concatenate([omega, (share * mass * np.exp(SKY_SHARPNESS * (1.0 - c)))[:, None]], -1)


def _th_rule(k: float, n: int) -> tuple[np.ndarray, np.ndarray]:
    """Gauss nodes [n] and weights in th; the mass of a row goes as 1 / sqrt(1 + k cos th), and is divided out again."""
    reach = min(HALF, 6.5 / np.sqrt(0.5 * k + 1e-9))
    th = _X * reach
    row_mass = 1 / np.sqrt(1 + k * np.cos(th))
    a, b = recurrence(th, _W * reach * np.cos(th) * np.exp(-2 * k * np.sin(th / 2) ** 2) * row_mass, n)
    th, w = nodes_and_weights(np.zeros_like(a), b)
    return th, w * np.sqrt(1 + k * np.cos(th))


class _Row(NamedTuple):
    """Points of one row, [COLUMNS, points]."""

    ph: np.ndarray
    w: np.ndarray  # scaled so that the largest is about 1
    log_scale: np.ndarray  # of w, [COLUMNS, 1]
    log_weight: np.ndarray  # the same with the row's mirror image


def _row_rules(k, angle, th, w_th, rows, row_count):
    """Per row the nodes ph [COLUMNS, n] and the logarithms of their weights; th, w_th, rows of one half of the rows.

    Rows with fewer nodes miss the leading moments; where the sum over th is concerned it is enough that the long rows
    add what the short ones lack, which changes the last coefficients of their recurrence.
    """
    n = max(rows)
    near = np.clip(angle, -HALF, HALF)[:, None]
    mirrored = [1 if 2 * i + 1 == row_count else 2 for i in range(len(rows))]
    points = [_row_points(k * np.cos(t), angle, near, w, m) for t, w, m in zip(th, w_th, mirrored, strict=True)]
    rules = [
        nodes_and_weights(*recurrence(points[i].ph - near, points[i].w, row)) if row < n else None
        for i, row in enumerate(rows)
    ]
    short = [(points[i], *rule) for i, rule in enumerate(rules) if rule is not None]
    long = [i for i, rule in enumerate(rules) if rule is None]
    top = np.max([points[i].log_weight for i in long], 0)
    mass = sum((points[i].w.sum(-1, keepdims=True) * np.exp(points[i].log_weight - top)) for i in long)
    nodes, logs = [], []
    for row, rule in zip(points, rules, strict=True):
        x, v = rule or _long_rule(row, near, n, short, top, mass)
        nodes.append(np.clip(x + near, -HALF, HALF))
        logs.append(np.log(np.maximum(v, 1e-300)) + row.log_scale)
    return nodes, logs


def _row_points(kappa, angle, near, w_th, mirrored) -> _Row:
    """Points on which the Gaussian along one row is as good as known; `mirrored`: how many rows are like it."""
    # Below the horizon the Gaussian falls off from it as exp(-kappa sin(depth) x).
    narrow = np.minimum(1 / np.sqrt(kappa / 2 + 0.05), 2 / (kappa * np.abs(np.sin(near - angle[:, None])) + 1e-9))
    # Broad ones under the nadir light both ends of the interval, so no part of it may be left out.
    reach = 7 * narrow if kappa > 40.0 else np.pi
    low, high = np.maximum(-HALF, near - reach), np.minimum(HALF, near + reach)
    ph = 0.5 * (low + high) + 0.5 * (high - low) * _X
    exponent = -2 * kappa * np.sin(0.5 * (ph - angle[:, None])) ** 2
    top = exponent.max(-1, keepdims=True)
    w = 0.5 * (high - low) * _W * np.exp(exponent - top)
    return _Row(ph, w, top + np.log(w_th), top + np.log(w_th * mirrored))


def _long_rule(row: _Row, near, n, short, top, mass) -> tuple[np.ndarray, np.ndarray]:
    """Nodes and weights of a long row, with its share by mass of what the short rows (points, nodes, weights) lack."""
    a, b = recurrence(row.ph - near, row.w, n)
    if short:
        missing = np.zeros((2, len(near)))
        for other, x, v in short:
            scale = np.exp(other.log_weight - top)[:, 0]
            exact, rule = (polynomial(p, a, b, n - 1) ** 2 for p in (other.ph - near, x))
            for m, (f, g) in enumerate(((1, 1), (other.ph - near - a[:, -1:], x - a[:, -1:]))):
                missing[m] += scale * ((other.w * exact * f).sum(-1) - (v * rule * g).sum(-1))
        own = b.prod(-1)  # the squared norm of the polynomial of degree n - 1
        # Deep below the horizon the outer rows outweigh the inner ones; then this much is as good as all.
        add = np.clip(missing[0] / mass[:, 0] * row.w.sum(-1), 0.0, own)
        limit = 0.25 * np.sqrt(b[:, -1])
        a[:, -1] += np.clip(missing[1] / mass[:, 0] * row.w.sum(-1) / (own + add), -limit, limit)
        b[:, -1] *= (own + add) / own
    return nodes_and_weights(a, b)
