"""The other built-in cloths: a throw over a pedestal, a gathered skirt on a dress form, a length of cloth in folds.

`glcloth drape NAME -o FILE` makes them again. They are simulated as the built-in cloth of drape.py is, and kept as the
vertices of the simulation; `load_mesh` lays a B-spline surface over these.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import Any, Literal

import moderngl
import numpy as np

from ..errors import InputError, meant
from ..geometry.supports import FORM, HEAD, PEDESTAL, WAIST, WAIST_AXES
from ..progress import track
from .cloth import Cloth, ClothParameters
from .solids import Box, Ellipsoid, Plane, Solid, Sphere

FRAMES_PER_SECOND = 60
FLOOR = Plane((0.0, 1.0, 0.0), 0.0)


@dataclasses.dataclass(frozen=True)
class Piece:
    """A cloth to be simulated.

    Parameters
    ----------
    size : m, along a row and down a column
    laid : where the vertices [R, C, 3] of a grid begin, R and C from the spacing
    cloth : of ClothParameters
    seconds : of falling, and then of settling, strongly damped
    held : what stays where it is: the first row, or the first and the last column
    """

    size: tuple[float, float]
    spacing: float
    laid: Callable[[int, int], np.ndarray]
    solids: tuple[Solid, ...]
    cloth: dict[str, Any]
    seconds: tuple[float, float] = (2.4, 0.8)
    held: Literal["", "row", "columns"] = ""


def _throw(rows: int, columns: int) -> np.ndarray:
    """A flat sheet over the ball, a little turned and off its middle."""
    side = 1.5 * (np.linspace(0.0, 1.0, rows) - 0.5)
    turn = np.radians(38.0)
    u = np.array([np.cos(turn), 0.0, -np.sin(turn)])
    v = np.array([-np.sin(turn), 0.0, -np.cos(turn)])
    return np.array([0.02, 1.24, 0.03]) + side[None, :, None] * u - side[:, None, None] * v


PLEATS, OVERLAP, FLARE = 26, 1.02, 0.62  # of the skirt: around, turns of its width, m of radius a metre of length


def _skirt(rows: int, columns: int) -> np.ndarray:
    """Pleats about the waist that open downwards, around and a little farther, so that they overlap at the back."""
    width, length = SKIRT
    turns = np.linspace(-0.5, 0.5, 60 * PLEATS + 1) * OVERLAP
    lines = []
    for down in np.linspace(0.0, length, rows):
        slope = np.hypot(1.0, FLARE)
        out, drop = FLARE * down / slope, down / slope
        angle = 2.0 * np.pi * turns
        # A spiral: the overlap lies within.
        inward = 0.006 * turns / OVERLAP
        # Pleats are not all alike.
        phase = 2.0 * np.pi * PLEATS * turns / OVERLAP + 0.7 * np.sin(3.0 * angle + 0.5) + 0.5 * np.sin(7.0 * angle)

        def ring(height, out=out, angle=angle, inward=inward, phase=phase, drop=drop):
            reach = np.stack([WAIST_AXES[0] + out, WAIST_AXES[1] + out]) + 0.018
            radial = height * np.sin(phase) + inward
            x, z = (reach[0] + radial) * np.sin(angle), (reach[1] + radial) * np.cos(angle)
            return np.column_stack([x, np.full_like(x, WAIST - drop), z])

        lines.append(_of_length(ring, width, columns))
    return np.array(lines)


def _folds(rows: int, columns: int) -> np.ndarray:
    """A length of cloth that was pushed together: waves across it, a hand high, that lean and wander."""
    width, depth = FOLDS
    lines = []
    across = np.linspace(0.0, 1.0, 1201)
    for z in np.linspace(-0.5, 0.5, rows) * depth:
        wander = 0.35 * np.sin(2.3 * z + 0.4) + 0.22 * np.sin(6.1 * z)
        t = across + 0.018 * np.sin(2 * np.pi * across + 3.0 * z)
        wave = 2.0 * np.pi * 4.0 * t + wander + 0.5 * np.sin(2.0 * np.pi * t)
        tall = 1.0 + 0.30 * np.sin(5.1 * t + 1.3 * z) + 0.12 * np.sin(11.0 * t)

        def line(height, wave=wave, tall=tall, z=z):
            y = 0.006 + height * tall * 0.5 * (1.0 - np.cos(wave))
            x = (across - 0.5) * 0.92 + 0.15 * height * np.sin(wave)
            return np.column_stack([x, y, np.full_like(x, z)])

        lines.append(_of_length(line, width, columns))
    return np.array(lines)


def _of_length(curve: Callable[[float], np.ndarray], length: float, count: int) -> np.ndarray:
    """`count` points at even distances along a curve whose height is so chosen that it has a length (m)."""
    low, high = 0.0, 0.4
    for _ in range(40):
        middle = 0.5 * (low + high)
        steps = np.linalg.norm(np.diff(curve(middle), axis=0), axis=1)
        low, high = (middle, high) if steps.sum() < length else (low, middle)
    points = curve(high)
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    at = np.linspace(0.0, along[-1], count)
    return np.column_stack([np.interp(at, along, points[:, k]) for k in range(3)])


SKIRT = 2.25, 0.60  # m: width and length
FOLDS = 1.24, 0.80
PIECES = {
    "throw": Piece(
        (1.5, 1.5), 0.0105, _throw, (FLOOR, Box(*PEDESTAL), Sphere(*HEAD)),
        {"mass": 0.25, "stretch": 1e4, "shear": 60.0, "bending": 2.5e-4, "friction": 0.4}, (3.6, 1.0),
    ),
    "skirt": Piece(
        SKIRT, 0.0098, _skirt, tuple(Ellipsoid(*part) for part in FORM),
        {"mass": 0.22, "stretch": 1e4, "shear": 60.0, "bending": 1.2e-4, "friction": 0.25}, (2.2, 1.2), held="row",
    ),
    "folds": Piece(
        FOLDS, 0.009, _folds, (FLOOR,),
        {"mass": 0.22, "stretch": 1e4, "shear": 60.0, "bending": 3e-4, "friction": 0.7}, (0.6, 0.7), held="columns",
    ),
}  # fmt: skip


def check_piece(name: str) -> None:
    """Raise InputError for an unknown piece."""
    if name not in PIECES:
        hint = meant(name, ("drape", *PIECES), "; did you mean {}?")
        raise InputError(f"drape {name}: unknown, expected drape, {', '.join(PIECES)}{hint}")


def simulated(ctx: moderngl.Context, name: str) -> tuple[np.ndarray, tuple[float, float]]:
    """The vertices [R, C, 3] of a piece at rest, and its size.

    Raises InputError for an unknown piece, and RuntimeError if contacts were lost.
    """
    check_piece(name)
    piece = PIECES[name]
    columns, rows = (round(side / piece.spacing) + 1 for side in piece.size)
    spacing = piece.size[0] / (columns - 1), piece.size[1] / (rows - 1)
    falling = ClothParameters(
        spacing, **piece.cloth, damping=1.5, gap=1.08 * max(spacing), substeps=20, air_substeps=5, speed_limit=2.0
    )
    settling = dataclasses.replace(falling, damping=12.0)
    pinned = np.zeros((rows, columns), bool)
    pinned[0] = piece.held == "row"
    pinned[:, [0, -1]] |= piece.held == "columns"
    cloth = Cloth(ctx, falling, piece.laid(rows, columns), piece.solids, pinned)
    first, last = (round(seconds * FRAMES_PER_SECOND) for seconds in piece.seconds)
    try:
        for frame in track(range(first + last), f"draping the {name}", first + last):
            cloth.parameters = falling if frame < first else settling
            cloth.step(1.0 / FRAMES_PER_SECOND)
        if lost := cloth.contacts_lost():
            raise RuntimeError(f"a vertex met {lost} others at once, more than MAX_NEAR in simulate/shared.glsl")
        return cloth.positions().astype(float), piece.size
    finally:
        cloth.release()
