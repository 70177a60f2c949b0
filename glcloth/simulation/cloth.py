"""Cloth in motion on the GPU: XPBD with small steps on a rectangular grid, solids, self-contact, wind, pins.

One substep (Macklin, Mueller, Chentanez 2016; Macklin et al. 2019, "Small steps in physics simulation") is
forces, predict -> even strips -> odd strips -> rows -> columns -> self-contact -> solids, friction, velocity.

The constraints are coloured by lines, not by edges: no two rows share a vertex, nor two columns, nor two even strips
of quads, nor two odd ones, so these four batches are free of races and the result is the same bit for bit in every
run. Within its line an invocation goes from end to end, which carries a pull down a hanging cloth in one pass, and
needs one load and one store per vertex. Stretch and shear are springs (N/m) along the yarns and the diagonals; bending
is the quadratic energy of isometric bending along both yarns (N m). Self-contact keeps the vertices `gap` apart; with
spacing <= gap <= 2 spacing no layer passes through another. The lists of near vertices come from a spatial hash whose
buckets are sorted, so that they do not depend on the order of atomic operations either; or from the vertex's own row, and so
many above and below.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import moderngl
import numpy as np

from ..errors import InputError
from ..gpu.buffers import Buffer, TextureBuffer
from ..gpu.layout import shared
from ..gpu.programs import programs
from ..progress import drain
from .backdrop import Backdrop
from .solids import Solid, solids_glsl

CONSTANTS, _ = shared("simulate/shared.glsl")
# Texel formats of blocks that some passes only read: by texelFetch, which is much faster.
FETCHED = {"Position": "rgba32f", "Previous": "rgba32f", "Velocity": "rgba32f", "AirForce": "rgba32f"}
FETCHED |= {"Near": "r32i", "NearCount": "r32i"}

NOTHING: Mapping[str, Any] = {}


@dataclass(frozen=True)
class Wind:
    """A wind whose mean is `velocity` (m/s), with gusts of +- `gustiness` of it (0..1) drifting through space."""

    velocity: tuple[float, float, float] = (0.0, 0.0, 0.0)
    gustiness: float = 0.4


@dataclass(frozen=True)
class ClothParameters:
    """The material of the cloth and how finely time is cut; SI units.

    spacing: distance of neighbouring vertices of the flat cloth along a row and down a column, m. mass: kg/m^2.
    stretch, shear: stiffness of the sheet along the yarns and on the bias, N/m (inf = does not give). bending: rigidity
    of the sheet along a yarn, N m. damping: share of the velocity lost per second, 1/s. drag: coefficients (across,
    along) the sheet. friction: Coulomb's coefficient against solids and itself. thickness: kept from solids, m. gap: kept
    between the cloth's own vertices, m (0 = no self-contact). contact_columns: 0 = all vertices may meet; else only those at
    most so many columns apart, of one row and of contact_rows above and below. apart: vertices nearer than that in the flat
    cloth are one layer, and need not keep the gap, m (neighbours never need to). least_fold: share of their distance that
    vertices at most two rows and columns apart keep, so that it is not crushed through itself (0 = not looked at). hem: factor on
    the mass of the last row. air_substeps: for how many substeps the air's force serves. rows_last: solve columns before
    rows; the last ones solved stretch least.
    """

    spacing: tuple[float, float]
    mass: float = 0.15
    stretch: float = 2000.0
    shear: float = 30.0
    bending: float = 5e-6
    damping: float = 0.5
    drag: tuple[float, float] = (1.3, 0.05)
    friction: float = 0.3
    thickness: float = 0.003
    gap: float = 0.0
    contact_columns: int = 0
    contact_rows: int = 0
    apart: float = 0.0
    least_fold: float = 0.0
    hem: float = 1.0
    gravity: tuple[float, float, float] = (0.0, -9.81, 0.0)
    substeps: int = 10
    air_substeps: int = 10
    rows_last: bool = False
    speed_limit: float = 10.0

    def __post_init__(self):
        positive = {"spacing": min(self.spacing), "mass": self.mass, "hem": self.hem, "speed_limit": self.speed_limit}
        positive |= {"stretch": self.stretch}
        for name, value in positive.items():
            if not value > 0:
                raise InputError(f"cloth: {name} = {value}, must be > 0; change it")
        if not 0 <= self.least_fold < 1:
            raise InputError(f"cloth: least_fold = {self.least_fold}, must be from 0 to less than 1; change it")
        for name in ("shear", "bending", "damping", "friction", "thickness", "gap", "apart"):
            if not getattr(self, name) >= 0:
                raise InputError(f"cloth: {name} = {getattr(self, name)}, must be >= 0; change it")
        if min(self.drag) < 0:
            raise InputError(f"cloth: drag = {self.drag}, must be >= 0; change it")
        # Where contact_columns is set rows meet rows only for `contact_rows`: the spacing in a row alone matters.
        widest, narrowest = (self.spacing[0],) * 2 if self.contact_columns else (max(self.spacing), min(self.spacing))
        least, most = widest, 2 * narrowest
        if self.apart >= self.gap:
            # Neighbours do not push each other apart, and no vertex is further from a layer's own than half a cell's diagonal.
            least, most = (least if self.contact_columns else math.hypot(*self.spacing) / 2), math.inf
        if self.gap and not least <= self.gap <= most:
            raise InputError(
                f"cloth: gap = {self.gap} m, must be 0 or between the spacing and twice the spacing {self.spacing}; "
                "change it or the number of vertices"
            )
        for name in ("contact_columns", "contact_rows"):
            if getattr(self, name) < 0:
                raise InputError(f"cloth: {name} = {getattr(self, name)}, must be >= 0; change it")
        for name in ("substeps", "air_substeps"):
            if getattr(self, name) < 1:
                raise InputError(f"cloth: {name} = {getattr(self, name)}, must be 1 or more; change it")


class Rail:
    """A rail along x whose heading, the first rows of a cloth, turns about it with the cloth below, as tape does on gliders.

    Held in one plane, a heading's wave would be crushed through itself where strong wind lifts the cloth into that plane.
    """

    FASTEST = 12.0  # rad/s
    BELOW = 2  # rows: the mean place of that below the heading says where the cloth goes

    def __init__(self, ctx: moderngl.Context, heading: np.ndarray, cloth_rows: int):
        """`heading` [rows, columns, 3], m, at rest: level, with the rail in the middle of its last row."""
        self.ctx, (rows, self.columns) = ctx, heading.shape[:2]
        self.row, self.held = min(rows + self.BELOW, cloth_rows - 1), rows * self.columns
        self.axis = float(heading[-1, 0, 1]), float(heading[..., 2].min() + heading[..., 2].max()) / 2
        data = np.zeros((1 + self.held, 4), np.float32)
        data[1:, :3] = heading.reshape(-1, 3) - [0.0, *self.axis]
        self._heading = Buffer(ctx, data.tobytes())

    @property
    def angle(self) -> float:
        """By how much it is turned, radians; positive where the cloth goes toward +z."""
        return float(np.frombuffer(self._heading.read(), np.float32)[0])

    def turn(self, buffers: dict[str, Buffer], duration: float) -> None:
        """Let the heading turn for so many seconds."""
        programs(self.ctx).compute("passes/simulation/heading.comp").run(
            64, buffers, Heading=self._heading, columns=self.columns, held=self.held, hanging=self.row, axis=self.axis,
            most=self.FASTEST * duration,
        )  # fmt: skip

    def release(self) -> None:
        """Free the GPU's memory."""
        self._heading.release()


class Cloth:
    """A rectangular cloth in motion; vertex (i, j) is row i (down yarn 2), column j (along yarn 1).

    Buffers for other passes, one vec4 a vertex in row-major order: `position_buffer` (w = inverse mass, 0 = pinned),
    `normal_buffer`, `tangent_buffer` (w = 1), the last two after `update_frames()`.
    """

    # Self-contact lists are made every so many substeps, and hold vertices nearer than LIST_REACH gaps.
    LIST_SUBSTEPS = 4
    ROW_LIST_SUBSTEPS = 6
    LIST_REACH = 1.6
    # Spacings that contact moves a vertex in a substep at most, where folds are minded.
    MOST_PUSH = 0.05

    def __init__(
        self,
        ctx: moderngl.Context,
        parameters: ClothParameters,
        positions: np.ndarray,
        colliders: Sequence[Solid] = (),
        pinned: np.ndarray | None = None,
        wind: Wind | None = None,
    ):
        """Lay the cloth at `positions` [rows, columns, 3] (m), at rest; `pinned` [rows, columns] bool never move.

        Raises InputError for fewer than 3 x 3 vertices, for positions that are not finite and for solids that make no sense.
        """
        positions = np.asarray(positions, np.float64)
        if positions.ndim != 3 or positions.shape[2] != 3 or min(positions.shape[:2]) < 3:
            raise InputError(f"cloth: positions have shape {positions.shape}, expected [rows >= 3, columns >= 3, 3]")
        if not np.isfinite(positions).all():
            raise InputError("cloth: positions must be finite; mend the starting shape")
        self.ctx = ctx
        self.parameters = parameters
        self.colliders = tuple(colliders)
        self._solids = solids_glsl(self.colliders)
        self.rows, self.columns = positions.shape[:2]
        self.vertex_count = self.rows * self.columns
        self.quad_count = (self.rows - 1) * (self.columns - 1)
        self.table_size = 1 << max(8, (2 * self.vertex_count - 1).bit_length())
        self.wind = wind or Wind()
        self._rail_data: TextureBuffer | None = None
        self.backdrop: Backdrop | None = None  # another cloth behind it, see `hang_before`
        self.rail: Rail | None = None  # on which the first row turns with the cloth
        self.time = 0.0
        self.substeps_done = 0
        self.inverse_mass = 1.0 / self._masses()
        if pinned is not None:
            self.inverse_mass[np.asarray(pinned, bool)] = 0.0
        V = self.vertex_count
        # Four-byte words of each buffer, by its name in the passes.
        words = {"Position": 4 * V, "Previous": 4 * V, "Velocity": 4 * V, "Air": 4 * V, "AirForce": 8 * self.quad_count}
        words |= {"Eliminated": 2 * V, "Normal": 4 * V, "Tangent": 4 * V, "Contact": 4 * V if parameters.gap else 4}
        if parameters.gap:
            words |= {"Near": V * CONSTANTS["MAX_NEAR"], "NearCount": V, "Overflow": 1}
        self._buffers: dict[str, Buffer] = {
            name: TextureBuffer(ctx, bytes(4 * count), FETCHED[name])
            if name in FETCHED
            else Buffer(ctx, bytes(4 * count))
            for name, count in words.items()
        }
        self._sizes = {"rows": self.rows, "columns": self.columns, "vertex_count": V, "table_size": self.table_size}
        self.position_buffer = self._buffers["Position"]
        self.normal_buffer = self._buffers["Normal"]
        self.tangent_buffer = self._buffers["Tangent"]
        self.set_state(positions)

    def _masses(self) -> np.ndarray:
        """Return [rows, columns] kg: the area that is nearest to each vertex, times the mass per area."""
        share_u, share_v = np.ones(self.columns), np.ones(self.rows)
        share_u[[0, -1]] = share_v[[0, -1]] = 0.5
        share_v[-1] *= self.parameters.hem
        return np.outer(share_v, share_u) * math.prod(self.parameters.spacing) * self.parameters.mass

    def _need_hash(self) -> None:
        """Have the buffers of the spatial hash."""
        if "Count" not in self._buffers:
            words = {name: self.table_size for name in ("Count", "Begin", "Cursor")} | {"Member": self.vertex_count}
            self._buffers |= {name: Buffer(self.ctx, bytes(4 * count)) for name, count in words.items()}

    def _run(self, path: str, items: int, *inputs: dict[str, Any], **own: Any) -> None:
        programs(self.ctx).compute(path).run(items, self._buffers, self._sizes, *inputs, **own)

    def hang_before(self, backdrop: Backdrop | None) -> None:
        """Let another cloth keep this one out from now on; None: no longer."""
        self.backdrop = backdrop
        if backdrop is None:
            self._solids = solids_glsl(self.colliders)
            return
        if self._rail_data is not None:
            self._solids = solids_glsl(self.colliders, backdrop=True)
            return
        rail = np.ascontiguousarray(self.positions()[0, :, 2], np.float32)
        self._rail_data = TextureBuffer(self.ctx, rail.tobytes(), "r32f")
        self._solids = solids_glsl(self.colliders, backdrop=True)

    def step(self, dt: float) -> None:
        """Advance by dt seconds in `parameters.substeps` equal substeps."""
        drain(self.steps(dt))

    def steps(self, dt: float) -> Iterator[None]:
        """As `step`, for a caller with other things to do in between: yields after every `air_substeps` substeps."""
        yield from steps_together([self], dt)

    def _values(self, dt: float) -> dict[str, Any]:
        """What `_advance` takes in a step of dt seconds."""
        if not (dt > 0 and math.isfinite(dt)):
            raise InputError(f"cloth: time step {dt} s, must be > 0; change it")
        m = self.parameters
        h = dt / m.substeps
        # Faster than half a gap in a substep, and two layers could change sides unseen.
        limit = min(m.speed_limit, 0.5 * m.gap / h) if m.gap else m.speed_limit
        return {
            "h": h, "gravity": m.gravity, "speed_limit": limit, "thickness": m.thickness, "mu": m.friction,
            "keep": math.exp(-m.damping * h),
        }  # fmt: skip

    def _before(self, values: dict[str, Any], share: float) -> None:
        """Take what hangs behind as it is when so much of the step has passed."""
        if self.backdrop is not None:
            values.update(self.backdrop.inputs(share), rail_data=self._rail_data, row_length=self.parameters.spacing[1])

    def _begin(self, values: dict[str, Any], k: int) -> None:
        """Begin substep k; where the air's force is not found anew, finish the one before."""
        m = self.parameters
        # The air changes slowly: its force serves several substeps, limited as one step of that length.
        renew = k % m.air_substeps == 0
        if renew:
            duration = values["h"] * min(m.air_substeps, m.substeps - k)
            if self.rail is not None:
                self.rail.turn(self._buffers, duration)
            if max(m.drag) > 0:
                self._air(duration)
        self._advance(values, finish=not renew, begin=True)

    def _advance(self, values: dict[str, Any], finish: bool = False, begin: bool = False) -> None:
        """Finish one substep, begin the next, or both."""
        defines = {"FINISH": int(finish), "BEGIN": int(begin), "CONTACT": int(self.parameters.gap > 0)}
        program = programs(self.ctx).compute("passes/simulation/advance.comp", defines, {"solids.glsl": self._solids})
        program.run(self.vertex_count, self._buffers, self._sizes, values)

    def _air(self, duration: float) -> None:
        m = self.parameters
        self._run(
            "passes/simulation/wind.comp", self.quad_count, h=duration, time=self.time, wind=self.wind.velocity,
            gustiness=self.wind.gustiness, C_n=m.drag[0], C_t=m.drag[1],
            triangle_mass=0.5 * math.prod(m.spacing) * m.mass,
        )  # fmt: skip
        self._run("passes/simulation/air.comp", self.vertex_count)

    def _constraints(self, h: float) -> None:
        m = self.parameters
        rest_u, rest_v = m.spacing
        backward = self.substeps_done & 1
        for parity in (0, 1):
            self._run(
                "passes/simulation/strips.comp", self.rows // 2, parity=parity, backward=backward,
                rest=math.hypot(rest_u, rest_v), shear_h2=_compliance(m.shear, h),
            )  # fmt: skip
        # The spring of one cell: a sheet of stiffness k N/m, as wide as the cell, over the cell's length.
        rows = (self.rows, self.columns, self.columns, 1, rest_u, rest_v)
        columns = (self.columns, self.rows, 1, self.columns, rest_v, rest_u)
        for lines, count, line_stride, stride, rest, width in (columns, rows) if m.rows_last else (rows, columns):
            self._run(
                "passes/simulation/lines.comp", lines, lines=lines, count=count, line_stride=line_stride, stride=stride,
                backward=backward, rest=rest, stretch_h2=_compliance(m.stretch * width / rest, h),
                bend_h2=_compliance(m.bending * width / rest**3, h),
            )  # fmt: skip

    def _contact(self, met: Mapping[str, Any] = NOTHING) -> None:
        """Find how far contact moves the vertices; `met`: the contacts with other cloths, if there are any."""
        m, V = self.parameters, self.vertex_count
        reach = self.LIST_REACH * m.gap
        if m.contact_columns and self.substeps_done % self.ROW_LIST_SUBSTEPS == 0:
            woven = max(1, math.ceil(m.apart / m.spacing[0]) - 1)
            self._run(
                "passes/simulation/near_rows.comp", V, window=m.contact_columns, row_window=m.contact_rows, reach=reach,
                woven=woven,
            )  # fmt: skip
        elif not m.contact_columns and self.substeps_done % self.LIST_SUBSTEPS == 0:
            self._sort_into_cells(reach)
            self._run("passes/simulation/near.comp", V, cell_size=reach, spacing=m.spacing, apart=m.apart)
        most = self.MOST_PUSH * min(m.spacing)
        folds = {"spacing": m.spacing, "least": m.least_fold, "most": most} if m.least_fold else {}
        defines = {"FOLDS": int(m.least_fold > 0), **({"MEETS": 1} if met else {})}
        contact = programs(self.ctx).compute("passes/simulation/contact.comp", defines)
        contact.run(V, self._buffers, self._sizes, gap=m.gap, mu=m.friction, **folds, **met)

    def _sort_into_cells(self, cell_size: float) -> dict[str, Any]:
        """Sort the vertices, as they are now, into the spatial hash; returns what looks into it binds."""
        self._need_hash()
        self._run("passes/simulation/count.comp", self.vertex_count, cell_size=cell_size)
        self._run("passes/simulation/scan.comp", 1)
        self._run("passes/simulation/fill.comp", self.vertex_count, cell_size=cell_size)
        self._run("passes/simulation/sort.comp", self.table_size)
        return {name: self._buffers[name] for name in ("Begin", "Cursor", "Member")} | {"table_size": self.table_size}

    def update_frames(self) -> None:
        """Compute `normal_buffer` and `tangent_buffer` from the present positions."""
        self._run("passes/simulation/normals.comp", self.vertex_count)

    def _read(self, buffer: Buffer) -> np.ndarray:
        return np.frombuffer(buffer.read(), np.float32).reshape(self.rows, self.columns, 4)[..., :3].copy()

    def positions(self) -> np.ndarray:
        """Return [rows, columns, 3] float32, m."""
        return self._read(self.position_buffer)

    def velocities(self) -> np.ndarray:
        """Return [rows, columns, 3] float32, m/s."""
        return self._read(self._buffers["Velocity"])

    def normals(self) -> np.ndarray:
        """Return [rows, columns, 3] float32 unit, as of the last `update_frames`."""
        return self._read(self.normal_buffer)

    def set_state(self, positions: np.ndarray, velocities: np.ndarray | None = None) -> None:
        """Put the vertices, pinned ones too, at `positions` [rows, columns, 3], with `velocities` or at rest."""
        state = np.zeros((self.vertex_count, 4), np.float32)
        state[:, :3], state[:, 3] = np.asarray(positions).reshape(-1, 3), self.inverse_mass.ravel()
        self.position_buffer.write(state)
        state[:] = 0
        if velocities is not None:
            state[:, :3] = np.asarray(velocities).reshape(-1, 3)
        self._buffers["Velocity"].write(state)

    def set_parameters(self, parameters: ClothParameters) -> None:
        """Take another material as the cloth hangs now; the spacing stays. Raises InputError for another spacing."""
        if parameters.spacing != self.parameters.spacing or (parameters.gap > 0) != (self.parameters.gap > 0):
            raise InputError("cloth: spacing and self-contact are fixed once it hangs; make another cloth")
        heavier = (parameters.mass, parameters.hem) != (self.parameters.mass, self.parameters.hem)
        self.parameters = parameters
        if heavier:
            self.inverse_mass = np.where(self.inverse_mass > 0.0, 1.0 / self._masses(), 0.0)
            self.set_state(self.positions(), self.velocities())

    def strain(self) -> np.ndarray:
        """Return the strains of all row and column edges, (length - rest) / rest, as one array."""
        x = self.positions().astype(float)
        along = [np.linalg.norm(np.diff(x, axis=axis), axis=2) for axis in (1, 0)]
        return np.concatenate([(l / rest - 1).ravel() for l, rest in zip(along, self.parameters.spacing, strict=True)])

    def contacts_lost(self) -> int:
        """Return the longest list of near vertices that did not fit in MAX_NEAR so far, 0 if all did."""
        return int(np.frombuffer(self._buffers["Overflow"].read(), np.int32)[0]) if self.parameters.gap else 0

    def release(self) -> None:
        """Free the GPU's memory."""
        for buffer in self._buffers.values():
            buffer.release()
        if self._rail_data is not None:
            self._rail_data.release()
        self._buffers.clear()
        if self.rail is not None:
            self.rail.release()


class Contacts(Protocol):
    """Finds the contacts between cloths."""

    def contacts(self, mu: float) -> list[dict[str, Any]]:
        """Those of each cloth, as they are now: what its contact pass binds."""


def steps_together(cloths: Sequence[Cloth], dt: float, meeting: Contacts | None = None) -> Iterator[None]:
    """Advance cloths that have as many substeps by dt seconds, substep by substep; as `Cloth.steps`.

    meeting : what keeps them from passing through each other; each has self-contact then
    """
    first = cloths[0].parameters
    values = [cloth._values(dt) for cloth in cloths]
    for k in range(first.substeps):
        for cloth, own in zip(cloths, values, strict=True):
            cloth._before(own, k / first.substeps)
        if k > 0 and k % first.air_substeps == 0:
            for cloth, own in zip(cloths, values, strict=True):
                cloth._advance(own, finish=True)
            yield
        for cloth, own in zip(cloths, values, strict=True):
            cloth._begin(own, k)
            cloth._constraints(own["h"])
        met = meeting.contacts(first.friction) if meeting is not None else [{} for _ in cloths]
        for cloth, own, others in zip(cloths, values, met, strict=True):
            if cloth.parameters.gap:
                cloth._contact(others)
            cloth.time += own["h"]
            cloth.substeps_done += 1
    for cloth, own in zip(cloths, values, strict=True):
        cloth._before(own, 1.0)
        cloth._advance(own, finish=True)
    yield


def _compliance(stiffness: float, h: float) -> float:
    """Return 1 / (k h^2), kg^-1, of a spring of k N/m; a spring of no stiffness gives without end (1e30)."""
    return min(1e30, 1.0 / (stiffness * h * h)) if stiffness > 0 else 1e30
