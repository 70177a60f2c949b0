"""A pleated curtain before a window, moved by gusts of wind; the simulation that the ray tracer shows frame by frame."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator
from typing import Any

import moderngl
import numpy as np
from scipy import sparse
from scipy.interpolate import CubicSpline
from scipy.sparse.linalg import spsolve

from ..errors import InputError
from ..geometry.mesh import Mesh, build_mesh
from ..geometry.shapes import grid_triangles
from ..scene import CurtainParameters
from ..simulation.cloth import Cloth, ClothParameters, Rail, Wind
from ..simulation.solids import Plane

# These may change while the curtain moves; for anything else it is hung anew.
SOFT = 3e-5  # N m: up to here the rate of the wind serves
CONVERGED = 0.021  # D h^2 / (mass spacing^4): there the sag of a strip is 2.4 % more than the elastica's
GAP = 1.05  # spacings along a row that folds keep from each other
# Where gusts exceed 1 m/s: folds keep further apart, the cloth is not crushed through itself, and its weave locks on the bias.
STRONG = {"gap": 1.4, "least_fold": 0.8, "shear": 40.0}
# Half diagonals of a cell that folds keep apart then, at least: less, and a vertex slips through the middle of a narrow cell.
CLOSED = 1.2
# Pleats meet side by side, so a row need only heed itself, so many pleats to either side. In strong wind narrow ones pile up, and
# so do those that another cloth pushes; they meet the rows above and below, too.
MEETS, PILES = 1.5, 3.0
ROD = 0.1376  # m, from the window to the middle of the built-in room's rod
LIVE = ("color", "wind", "gustiness", "stretch", "shear", "bending", "mass", "hem", "damping", "openness")


class CurtainSimulation:
    """A curtain in motion. Its buffers hold one vec4 a vertex, `rows` x `columns` of them row by row from the top:
    `position_buffer` (m), `normal_buffer` (+z side), `tangent_buffer` (yarn 1, along the rail)."""

    # Substeps per second for gusts up to 1 m/s; beyond, in proportion to the wind's pressure, so that folds
    # crushed under the heading stretch no thread by more than 5 %, up to twice that wind: stronger ones lift the cloth,
    # and the heading turns with it.
    SUBSTEP_RATE = 288
    MOST_SUBSTEPS = 4 * SUBSTEP_RATE
    RINGS_FACTOR = 2  # under a ring the whole pleat hangs on one thread

    def __init__(
        self,
        ctx: moderngl.Context,
        parameters: CurtainParameters | None = None,
        settle: bool = True,
        shift: float = 0.0,
    ):
        """Hang the curtain and let it settle; deterministic. Raises InputError as CurtainParameters does, and for cloth so
        stiff that it would bend too easily.

        settle : False leaves that to a caller who goes through `settling()` before the first step
        shift : by which the middle of its rail is off x = 0, m
        """
        self.parameters = m = parameters or CurtainParameters()
        self.pushed = 0.0  # m/s, the strongest wind on a cloth that pushes this one
        self._least_rate = _rate_for_bending(m, self.MOST_SUBSTEPS)
        columns, rows = m.quads[0] + 1, m.quads[1] + 1
        rail = pleated_rail(m, columns)
        positions = np.empty((rows, columns, 3))
        positions[..., 0], positions[..., 2] = rail[:, 0] + shift, rail[:, 1]
        positions[..., 1] = np.linspace(m.upper, m.upper - m.drop, rows)[:, None]
        pinned = np.zeros((rows, columns), bool)
        pinned[0] = _crests(rail[:, 1]) if m.heading == "rings" else True
        # About a rod the cloth is held where the rod is, too.
        held = 1 + round((m.upper - m.top) * m.quads[1] / m.drop)
        pinned[:held] |= held > 1
        spacing = _spacing(m)
        self._heading = positions[:held].copy()
        cloth = ClothParameters(
            spacing=spacing,
            **_material(m),
            thickness=0.01,
            gap=GAP * spacing[0],
            contact_columns=int(MEETS * m.quads[0] / m.pleats),
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
        self._blow()
        self.cloth.update_frames()

    def _blow(self) -> None:
        """Let the wind of the parameters blow from now on, and make the cloth ready for it."""
        m, cloth = self.parameters, self.cloth
        cloth.wind = Wind((0.0, 0.0, m.wind), m.gustiness)
        strong = self.strong
        spacing = cloth.parameters.spacing
        own: dict[str, Any] = {"gap": GAP, "least_fold": 0.0, "shear": m.shear, "apart": 0.0, "contact_rows": 0} | (
            STRONG if strong else {}
        )
        own["contact_columns"] = int(MEETS * m.quads[0] / m.pleats)
        own["gap"] *= spacing[0]
        own["shear"] = max(own["shear"], m.shear)
        if strong:
            closed = CLOSED * math.hypot(*spacing) / 2
            if closed > own["gap"] or self.pushed:
                own |= {"contact_columns": int(PILES * m.quads[0] / m.pleats), "contact_rows": 1}
            own["gap"] = own["apart"] = max(own["gap"], closed)
        cloth.set_parameters(dataclasses.replace(cloth.parameters, **own))
        # Once it turns it may turn back.
        if strong and m.heading != "rings" and cloth.rail is None:
            cloth.rail = Rail(cloth.ctx, self._heading, cloth.rows)

    @property
    def strong(self) -> bool:
        """Whether it hangs in a wind that lifts cloth, or before cloth that does."""
        return max(gusts(self.parameters), self.pushed) > 1.0

    def can_change(self, parameters: CurtainParameters) -> bool:
        """Whether `change` takes other parameters. Raises InputError for cloth so stiff that it would bend too easily."""
        _rate_for_bending(parameters, self.MOST_SUBSTEPS)
        return self.parameters.changed(**{name: getattr(parameters, name) for name in LIVE}) == parameters

    def change(self, parameters: CurtainParameters) -> bool:
        """Take other parameters while the curtain moves; False, and nothing done, where it must be hung anew for them."""
        if not self.can_change(parameters):
            return False
        self._least_rate = _rate_for_bending(parameters, self.MOST_SUBSTEPS)
        self.parameters = m = parameters
        self.cloth.set_parameters(dataclasses.replace(self.cloth.parameters, **_material(m)))
        self._blow()
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

    def substeps(self, dt: float) -> int:
        """How many substeps dt seconds need."""
        m = self.parameters
        rate = max(self.SUBSTEP_RATE * max(1.0, gusts(m), self.pushed) ** 2, self._least_rate)
        rate = min(rate * (self.RINGS_FACTOR if m.heading == "rings" else 1), self.MOST_SUBSTEPS)
        return max(1, math.ceil(dt * rate - 1e-9))

    def _advance(self, dt: float) -> Iterator[None]:
        self.take_substeps(self.substeps(dt))
        yield from self.cloth.steps(dt)

    def take_substeps(self, substeps: int) -> None:
        """Have so many substeps in a step from now on."""
        if substeps != self.cloth.parameters.substeps:
            self.cloth.parameters = dataclasses.replace(self.cloth.parameters, substeps=substeps)

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


def _spacing(m: CurtainParameters) -> tuple[float, float]:
    """Of the vertices of the flat cloth, along a row and down a column, m."""
    return m.width * m.fullness / m.quads[0], m.drop / m.quads[1]


def _rate_for_bending(m: CurtainParameters, most: float) -> float:
    """Substeps per second that a stiff cloth needs, 0 for a soft one. Raises InputError where these are more than `most`.

    Bending is solved once a substep h: where D h^2 / (mass spacing^4) is larger, cloth bends as if it were softer.
    """
    if m.bending <= SOFT:
        return 0.0
    per = CONVERGED * m.mass * min(_spacing(m)) ** 4
    if m.bending > per * most**2:
        raise InputError(
            f"curtain: bending = {m.bending:g} N m: with a mass of {m.mass:g} kg/m^2 and cells of {min(_spacing(m)):.3g} m it "
            f"would be too soft beyond {max(per * most**2, SOFT):.2g}; give less, or fewer quads"
        )
    return math.sqrt(m.bending / per)


def gusts(m: CurtainParameters) -> float:
    """The strongest wind, m/s."""
    return abs(m.wind) * (1 + m.gustiness)


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
    off = m.clearance - z.min()
    if m.heading in ("eyelet", "rod"):
        off = max(off, ROD - (z.min() + z.max()) / 2)
    return np.column_stack([(t - 0.5) * m.width, z + off])


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
