"""The built-in cloth: a square piece dropped over a ball that stands near the edge of a table.

`glcloth drape -o FILE` makes it again. The cloth is simulated (glcloth.simulation.cloth, with self-contact), then laid as a
cubic B-spline surface over the simulated vertices and sampled more finely: second derivatives are continuous, so
highlights run smoothly along the folds, and the normals are exact. UVs are metres of cloth, so yarns stay evenly
spaced wherever the folds take them.
"""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import moderngl
import numpy as np

from ..errors import InputError
from ..geometry.mesh import Mesh
from ..geometry.mesh_files import BALL, TABLE, load_mesh
from ..geometry.spline import spline, surface_mesh
from ..progress import track
from .cloth import Cloth, ClothParameters, Wind
from .solids import Box, Sphere

SIZE = 1.6  # m, side of the cloth
CLOTH: dict[str, Any] = {"mass": 0.15, "stretch": 1e4, "bending": 4e-5, "friction": 0.5}  # falling, and in the wind
TURN_DEG = 42.0  # of the cloth on the table
SOLIDS = (Box(*TABLE), Sphere(*BALL))
CENTER = (0.03, 0.36, 0.2)  # m, of the flat cloth before it falls
FRAMES_PER_SECOND = 60
SETTLE = 0.7  # s at the end in which strong damping brings the cloth to rest ...
RELAX = 0.25  # ... and s after that, with little friction, in which threads that the table's edge holds taut give way
WIND_AXIS = np.array([0.8, 0.0, 0.6])  # along the table's edge and away from it
SUBSTEP_RATE = 720  # per second, in the wind
NEAR_SOLID = 0.006  # m
HANG = 0.4  # s, before it begins


def drape(ctx: moderngl.Context, vertices: int = 168, samples: int = 150, seconds: float = 4.0) -> Mesh:
    """Return the draped cloth with (samples - 1)^2 * 2 triangles, simulated with vertices x vertices for `seconds`.

    Raises InputError for counts or a time that make no cloth, and RuntimeError if contacts were lost.
    """
    if vertices < 16 or samples < 16:
        raise InputError(f"drape: {vertices} vertices, {samples} samples a side, expected 16 or more of each")
    if not 0 < seconds < 60:
        raise InputError(f"drape: {seconds} s, expected more than 0 and less than 60")
    side = np.linspace(-SIZE / 2, SIZE / 2, vertices)
    spacing = SIZE / (vertices - 1)
    turn = np.radians(TURN_DEG)
    along_u = np.array([np.cos(turn), 0.0, -np.sin(turn)])
    along_v = np.array([-np.sin(turn), 0.0, -np.cos(turn)])
    flat = CENTER + side[None, :, None] * along_u - side[:, None, None] * along_v
    falling = ClothParameters(
        spacing=(spacing, spacing),
        **CLOTH,
        damping=1.5,
        gap=1.05 * spacing,
        substeps=20,
        air_substeps=5,
        speed_limit=2.0,
    )
    settling = dataclasses.replace(falling, damping=15.0, friction=0.4)
    relaxing = dataclasses.replace(settling, friction=0.15)
    cloth = Cloth(ctx, falling, flat, SOLIDS)
    try:
        frames = max(1, round(seconds * FRAMES_PER_SECOND))
        for frame in track(range(frames + round(RELAX * FRAMES_PER_SECOND)), "draping"):
            if frame >= frames:
                cloth.parameters = relaxing
            elif frame >= frames - SETTLE * FRAMES_PER_SECOND:
                cloth.parameters = settling
            cloth.step(1.0 / FRAMES_PER_SECOND)
        if lost := cloth.contacts_lost():
            raise RuntimeError(f"a vertex met {lost} others at once, more than MAX_NEAR in simulate/shared.glsl")
        return surface_mesh("drape", cloth.positions(), (SIZE, SIZE), samples, samples)
    finally:
        cloth.release()


def _unit(v: np.ndarray) -> np.ndarray:
    return v / np.maximum(np.linalg.norm(v, axis=-1, keepdims=True), 1e-12)


def lying(positions: np.ndarray) -> np.ndarray:
    """Which vertices [..., 3] lie on the table or the ball, bool [...]: more of the cloth hangs than they could hold by
    friction for long."""
    table, ball = SOLIDS
    on_table = np.abs(positions[..., 1] - table.center[1] - table.half_size[1]) < NEAR_SOLID
    on_table &= (np.abs(positions - table.center) < np.array(table.half_size) - table.rounding)[..., [0, 2]].all(-1)
    from_ball = np.linalg.norm(positions - np.array(ball.center), axis=-1) - ball.radius
    return on_table | ((np.abs(from_ball) < NEAR_SOLID) & (positions[..., 1] > ball.center[1]))


class Swaying:
    """The built-in cloth in the wind, from where it came to rest on; its poses are meshes with the same triangles.

    Deterministic. Raises InputError for a wind of more than 20 m/s.
    """

    def __init__(self, ctx: moderngl.Context, wind: float):
        """`wind`: m/s, along the table's edge and away from it."""
        if not abs(wind) <= 20:
            raise InputError(f"--wind {wind}: expected at most 20 m/s")
        mesh = load_mesh("drape")
        side = round(len(mesh.positions) ** 0.5)
        spacing = SIZE / (side - 1)
        parameters = ClothParameters(
            spacing=(spacing, spacing),
            **CLOTH,
            damping=0.6,
            gap=spacing,
            speed_limit=5.0,
        )
        self._rest, self._spline = mesh, spline(side, side)
        positions = mesh.positions.reshape(side, side, 3).astype(float)
        self.cloth = Cloth(ctx, parameters, positions, SOLIDS, lying(positions))
        # The finer cloth was pressed together; this one lets go before the wind begins.
        self._advance(HANG, 8.0)
        self.frame = 0  # how many steps were taken
        self.cloth.time = 0.0
        self.cloth.wind = Wind(tuple(wind * WIND_AXIS), 0.8)

    def _advance(self, seconds: float, damping: float) -> None:
        # Contacts are found anew at each step.
        steps = max(1, math.ceil(seconds * FRAMES_PER_SECOND))
        substeps = math.ceil(seconds * SUBSTEP_RATE / steps)
        self.cloth.parameters = dataclasses.replace(self.cloth.parameters, substeps=substeps, damping=damping)
        for _ in range(steps):
            self.cloth.step(seconds / steps)

    def step(self, seconds: float) -> None:
        """Let the wind blow for a while."""
        self._advance(seconds, 0.6)
        self.frame += 1

    def mesh(self) -> Mesh:
        """The present pose."""
        positions = self.cloth.positions().astype(float)
        weights, slopes = self._spline
        u_slope, v_slope = (
            np.einsum("ri,cj,ijk->rck", *pair, positions, optimize=True).reshape(-1, 3)
            for pair in ((weights, slopes), (slopes, weights))
        )
        N = _unit(np.cross(v_slope, u_slope))  # v falls down the rows
        x = _unit(u_slope - (u_slope * N).sum(1, keepdims=True) * N)
        x = np.concatenate([x, self._rest.tangents[:, 3:]], 1)
        smooth = np.einsum("ri,cj,ijk->rck", weights, weights, positions, optimize=True).reshape(-1, 3)
        return dataclasses.replace(self._rest, positions=smooth, normals=N, tangents=x)

    def release(self) -> None:
        """Free the GPU's memory."""
        self.cloth.release()
