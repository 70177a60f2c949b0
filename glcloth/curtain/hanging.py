"""A pleated curtain before a window, moved by gusts of wind; the simulation that the ray tracer shows frame by frame."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

import moderngl
import numpy as np
from scipy import sparse
from scipy.interpolate import CubicSpline
from scipy.sparse.linalg import spsolve

from ..errors import InputError
from ..geometry.mesh import Mesh, build_mesh
from ..geometry.shapes import grid_triangles
from ..simulation.cloth import Cloth, ClothParameters, Wind
from ..simulation.solids import Plane


@dataclass(frozen=True)
class CurtainParameters:
    """A curtain on a rail along x, the window in the plane z = 0 behind it, the floor at y = 0; SI units.

    width, top: length of the rail, its height, m. clearance: from the window to the backs of the pleats, m. drop: length
    of the cloth, m.
    fullness: width of the cloth over that of the rail. pleats: folds along the rail. irregularity: how unequal they are
    (0 = all alike). quads: cells of the grid along the rail and down the cloth. heading: "tape" holds the whole upper
    edge in pleats, "rings" only the front of each pleat. mass: kg/m^2. stretch, shear: N/m. bending: N m. hem: factor on
    the mass of the lowest row. wind: m/s, perpendicular to the window into the room; gustiness: 0..1. openness: share
    of the cloth that lets air through. damping: 1/s. settle: seconds without wind before the first frame.
    """

    width: float = 2.5
    top: float = 2.41
    clearance: float = 0.06
    drop: float = 2.3
    fullness: float = 1.8
    pleats: int = 13
    irregularity: float = 0.2
    quads: tuple[int, int] = (158, 40)
    heading: Literal["tape", "rings"] = "tape"
    mass: float = 0.06
    stretch: float = 3000.0
    shear: float = 15.0
    bending: float = 3e-5
    hem: float = 2.0
    wind: float = 0.5
    gustiness: float = 1.0
    openness: float = 0.35
    damping: float = 0.6
    settle: float = 1.5

    def __post_init__(self):
        for name in ("width", "drop", "clearance", "mass", "stretch", "hem"):
            if not getattr(self, name) > 0:
                raise InputError(f"curtain: {name} = {getattr(self, name)}, must be > 0; change it")
        if not 1.0 <= self.fullness <= 4.0:
            raise InputError(f"curtain: fullness = {self.fullness}, must be 1 to 4 (sheers 1.8 to 3); change it")
        if not 1 <= self.pleats <= self.quads[0] // 6:
            raise InputError(
                f"curtain: pleats = {self.pleats} on {self.quads[0]} quads, must be 1 to {self.quads[0] // 6}, "
                "six quads each; change one of them"
            )
        if min(self.quads) < 6:
            raise InputError(f"curtain: quads = {self.quads}, must be 6 or more each; change them")
        if self.heading not in ("tape", "rings"):
            raise InputError(f"curtain: heading {self.heading!r}, expected tape or rings")
        for name in ("irregularity", "gustiness", "openness"):
            if not 0 <= getattr(self, name) <= 1:
                raise InputError(f"curtain: {name} = {getattr(self, name)}, must be 0 to 1; change it")
        if not abs(self.wind) <= 20:
            raise InputError(f"curtain: wind = {self.wind} m/s, must be at most 20; change it")
        if not 0 <= self.settle <= 60:
            raise InputError(f"curtain: settle = {self.settle} s, must be 0 to 60; change it")

    def with_triangles(self, count: int) -> CurtainParameters:
        """Return a curtain of about `count` triangles in the same proportions, with as many pleats as they can show."""
        if count < 144:
            raise InputError(f"curtain: {count} triangles, expected 144 or more")
        across = max(12, round(math.sqrt(count / 2 * self.quads[0] / self.quads[1])))
        return dataclasses.replace(
            self, quads=(across, max(6, round(count / 2 / across))), pleats=max(1, min(self.pleats, across // 12))
        )

    @property
    def triangle_count(self) -> int:
        """How many triangles the curtain has."""
        return 2 * self.quads[0] * self.quads[1]


# What may change while the curtain moves; for anything else it is hung anew.
LIVE = ("wind", "gustiness", "stretch", "shear", "bending", "mass", "hem", "damping", "openness")


class CurtainSimulation:
    """A curtain in motion. Its buffers hold one vec4 a vertex, `rows` x `columns` of them row by row from the top:
    `position_buffer` (m), `normal_buffer` (+z side), `tangent_buffer` (yarn 1, along the rail)."""

    # Substeps per second for gusts up to 1 m/s; beyond, in proportion to the wind's pressure, so that folds
    # crushed under the heading stretch no thread by more than 5 %.
    SUBSTEP_RATE = 288
    RINGS_FACTOR = 2  # under a ring the whole pleat hangs on one thread

    def __init__(self, ctx: moderngl.Context, parameters: CurtainParameters | None = None, settle: bool = True):
        """Hang the curtain and let it settle; deterministic. Raises InputError as CurtainParameters does.

        settle : False leaves that to a caller who goes through `settling()` before the first step
        """
        self.parameters = m = parameters or CurtainParameters()
        columns, rows = m.quads[0] + 1, m.quads[1] + 1
        rail = pleated_rail(m, columns)
        positions = np.empty((rows, columns, 3))
        positions[..., 0], positions[..., 2] = rail[:, 0], rail[:, 1]
        positions[..., 1] = np.linspace(m.top, m.top - m.drop, rows)[:, None]
        pinned = np.zeros((rows, columns), bool)
        pinned[0] = True if m.heading == "tape" else _crests(rail[:, 1])
        spacing = (m.width * m.fullness / m.quads[0], m.drop / m.quads[1])
        cloth = ClothParameters(
            spacing=spacing,
            **_material(m),
            thickness=0.01,
            # Pleats meet side by side, so a row need only heed itself, one and a half pleats to either side.
            gap=1.05 * spacing[0],
            contact_columns=3 * m.quads[0] // (2 * m.pleats),
            # Pleats that are crushed together pull at the threads along the rail.
            rows_last=True,
            air_substeps=12,
        )
        solids = (Plane((0.0, 0.0, 1.0), 0.0), Plane((0.0, 1.0, 0.0), 0.0))
        self.cloth = Cloth(ctx, cloth, positions, solids, pinned, Wind((0.0, 0.0, 0.0)))
        self.rows, self.columns = rows, columns
        self.position_buffer = self.cloth.position_buffer
        self.normal_buffer = self.cloth.normal_buffer
        self.tangent_buffer = self.cloth.tangent_buffer
        for _ in self.settling() if settle else ():
            pass

    def settling(self) -> Iterator[float]:
        """Let the curtain hang without wind, then let the wind begin; yields the share that is done."""
        steps = round(self.parameters.settle * 30)
        for k in range(steps):
            for _ in self._advance(1 / 30):
                yield k / steps
        self.cloth.time = 0.0
        self.cloth.wind = Wind((0.0, 0.0, self.parameters.wind), self.parameters.gustiness)
        self.cloth.update_frames()

    def change(self, parameters: CurtainParameters) -> bool:
        """Take other parameters while the curtain moves; False, and nothing done, where it must be hung anew for them."""
        m = self.parameters
        if dataclasses.replace(m, **{name: getattr(parameters, name) for name in LIVE}) != parameters:
            return False
        self.parameters = m = parameters
        self.cloth.set_parameters(dataclasses.replace(self.cloth.parameters, **_material(m)))
        self.cloth.wind = Wind((0.0, 0.0, m.wind), m.gustiness)
        return True

    @property
    def time(self) -> float:
        """Seconds since the wind began."""
        return self.cloth.time

    def step(self, dt: float) -> None:
        """Advance by dt seconds; normals and tangents are up to date then."""
        for _ in self.steps(dt):
            pass

    def steps(self, dt: float) -> Iterator[None]:
        """As `step`, a few substeps at a time, for a caller with other things to do in between."""
        yield from self._advance(dt)
        self.cloth.update_frames()

    def _advance(self, dt: float) -> Iterator[None]:
        m = self.parameters
        rate = self.SUBSTEP_RATE * max(1.0, abs(m.wind) * (1 + m.gustiness)) ** 2
        rate *= self.RINGS_FACTOR if m.heading == "rings" else 1
        substeps = max(1, math.ceil(dt * rate - 1e-9))
        if substeps != self.cloth.parameters.substeps:
            self.cloth.parameters = dataclasses.replace(self.cloth.parameters, substeps=substeps)
        yield from self.cloth.steps(dt)

    def positions(self) -> np.ndarray:
        """Return [rows, columns, 3] float32, m."""
        return self.cloth.positions()

    def mesh(self, name: str = "curtain") -> Mesh:
        """Return the present shape; UVs are metres of cloth."""
        u = np.linspace(0.0, self.parameters.width * self.parameters.fullness, self.columns)
        v = np.linspace(self.parameters.drop, 0.0, self.rows)
        uv = np.stack(np.meshgrid(u, v), axis=-1).reshape(-1, 2)
        triangles = grid_triangles(self.rows, self.columns)
        return build_mesh(name, self.positions().reshape(-1, 3), triangles, uv, self.cloth.normals().reshape(-1, 3))

    def release(self) -> None:
        """Free the GPU's memory."""
        self.cloth.release()


def _material(m: CurtainParameters) -> dict:
    """The fields of ClothParameters that may change while the curtain moves."""
    kept = {name: getattr(m, name) for name in ("mass", "stretch", "shear", "bending", "damping", "hem")}
    return kept | {"drag": (1.3 * (1 - m.openness), 0.05 * (1 - m.openness))}


def pleated_rail(parameters: CurtainParameters, columns: int) -> np.ndarray:
    """Return [columns, 2]: (x, z) of the upper edge, a wave of straight pieces as long together as the cloth is wide.

    The pieces are equally long, so that no thread starts out stretched or slack.
    """
    m = parameters
    s = np.linspace(0.0, 1.0, 400 * m.pleats + 1)
    # Unequal pleats: the phase runs ahead and behind by two slow waves, the height follows a third.
    phase = s * m.pleats + m.irregularity * (0.5 * np.sin(7.3 * s + 1.0) + 0.5 * np.sin(17.9 * s)) * s * (1 - s) * 4
    wave = CubicSpline(s, np.cos(2 * np.pi * phase) * (1 + 0.5 * m.irregularity * np.sin(11.0 * s + 2.0)))
    t, height = np.linspace(0.0, 1.0, columns), 0.0
    # From flat to full in small steps, each from the last one's solution: Newton's method alone loses its way in folds.
    for fullness in (
        np.linspace(1.0, m.fullness, max(2, math.ceil((m.fullness - 1) / 0.05)))[1:] if m.fullness > 1 else ()
    ):
        t, height = _equal_pieces(wave, m.width, m.width * fullness / (columns - 1), t, height)
    z = height * wave(t)
    return np.column_stack([(t - 0.5) * m.width, z - z.min() + m.clearance])


def _equal_pieces(wave: CubicSpline, width: float, piece: float, t: np.ndarray, height: float) -> tuple:
    """Return (t, height) such that the points (width t, height wave(t)) are `piece` apart, both ends of t kept: Newton."""
    inner = np.arange(len(t) - 2)
    height = max(height, 0.05 * width / len(t))
    for _ in range(60):
        dt, dz, slope = np.diff(t), np.diff(wave(t)), wave(t, 1)
        length = np.hypot(dt * width, dz * height)
        if np.abs(length - piece).max() < 1e-6 * piece:
            return t, height
        ahead = (width**2 * dt + height**2 * dz * slope[1:]) / length
        behind = (width**2 * dt + height**2 * dz * slope[:-1]) / length
        jacobian = sparse.lil_array((len(t) - 1, len(t) - 1))
        jacobian[inner, inner] = ahead[:-1]
        jacobian[inner + 1, inner] = -behind[1:]
        jacobian[:, [-1]] = (height * dz**2 / length)[:, None]
        change = spsolve(jacobian.tocsc(), piece - length)
        # No column may overtake its neighbour, and no step is a leap.
        closing = -np.diff(np.concatenate([[0.0], change[:-1], [0.0]])) / dt
        share = min(1.0, 0.5 / max(closing.max(), 1e-9), 0.5 * height / max(abs(change[-1]), 1e-12))
        t = t + share * np.concatenate([[0.0], change[:-1], [0.0]])
        height += share * change[-1]
    raise InputError(
        f"curtain: {len(t) - 1} quads across are too few for pleats as full as these; use more quads, fewer pleats or "
        "less fullness"
    )


def _crests(z: np.ndarray) -> np.ndarray:
    """Return [columns] bool: the front of each pleat, and both ends."""
    crest = np.zeros(len(z), bool)
    crest[1:-1] = (z[1:-1] >= z[:-2]) & (z[1:-1] > z[2:])
    crest[[0, -1]] = True
    return crest
