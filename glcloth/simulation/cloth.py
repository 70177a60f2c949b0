"""Cloth in motion on the GPU: XPBD with small steps on a rectangular grid, solids, self-contact, wind, pins.

One substep (Macklin, Mueller, Chentanez 2016; Macklin et al. 2019, "Small steps in physics simulation") is
forces, predict -> even strips -> odd strips -> rows -> columns -> self-contact -> solids, friction, velocity.

The constraints are coloured by lines, not by edges: no two rows share a vertex, nor two columns, nor two even strips
of quads, nor two odd ones, so these four batches are free of races and the result is the same bit for bit in every
run. Within its line an invocation goes from end to end, which carries a pull down a hanging cloth in one pass, and
needs one load and one store per vertex. Stretch and shear are springs (N/m) along the yarns and the diagonals; bending
is the quadratic energy of isometric bending along both yarns (N m). Self-contact keeps the vertices `gap` apart; with
spacing <= gap <= 2 spacing no layer passes through another. The lists of near vertices come from a spatial hash whose
buckets are sorted, so that they do not depend on the order of atomic operations either; or from the vertex's own row.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import moderngl
import numpy as np

from ..errors import InputError
from ..gpu import shader
from ..gpu.buffers import TextureBuffer
from ..gpu.layout import shared

CONSTANTS, _ = shared("simulate/shared.glsl")
ADVANCE = "Position Previous Velocity Air Contact"
# Blocks that some passes only read, by texelFetch, which is much faster: their texel formats.
FETCHED = {"Position": "rgba32f", "Previous": "rgba32f", "Velocity": "rgba32f", "AirForce": "rgba32f"}
FETCHED |= {"Near": "r32i", "NearCount": "r32i"}


@dataclass(frozen=True)
class Plane:
    """The half space dot(normal, p) <= offset is solid; `normal` is made unit, and the offset with it."""

    normal: tuple[float, float, float]
    offset: float = 0.0


@dataclass(frozen=True)
class Sphere:
    """A solid ball; metres."""

    center: tuple[float, float, float]
    radius: float


@dataclass(frozen=True)
class Box:
    """A solid box with outer half sides `half_size`, its edges rounded with `rounding`; metres."""

    center: tuple[float, float, float]
    half_size: tuple[float, float, float]
    rounding: float = 0.0


Solid = Plane | Sphere | Box


@dataclass(frozen=True)
class Wind:
    """A wind whose mean is `velocity` (m/s), with gusts of +- `gustiness` of it (0..1) drifting through space."""

    velocity: tuple[float, float, float] = (0.0, 0.0, 0.0)
    gustiness: float = 0.4


@dataclass(frozen=True)
class ClothParameters:
    """What the cloth is made of and how finely time is cut; SI units.

    spacing: distance of neighbouring vertices of the flat cloth along a row and down a column, m. mass: kg/m^2.
    stretch, shear: stiffness of the sheet along the yarns and on the bias, N/m (inf = does not give). bending: rigidity
    of the sheet along a yarn, N m. damping: share of the velocity lost per second, 1/s. drag: coefficients (across,
    along) the sheet. friction: Coulomb's coefficient against solids and itself. thickness: kept from solids, m. gap:
    kept between the cloth's own vertices, m (0 = no self-contact). contact_columns: 0 = all vertices may meet; else only
    those of one row, at most so many columns apart. hem: factor on the mass of the last row. air_substeps: for how many
    substeps the air's force serves. rows_last: solve columns before rows; what is solved last is stretched least.
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
        for name in ("shear", "bending", "damping", "friction", "thickness", "gap"):
            if not getattr(self, name) >= 0:
                raise InputError(f"cloth: {name} = {getattr(self, name)}, must be >= 0; change it")
        if min(self.drag) < 0:
            raise InputError(f"cloth: drag = {self.drag}, must be >= 0; change it")
        # Between rows nothing is looked at when contact_columns is set: then only the spacing in a row matters.
        widest, narrowest = (self.spacing[0],) * 2 if self.contact_columns else (max(self.spacing), min(self.spacing))
        if self.gap and not widest <= self.gap <= 2 * narrowest:
            raise InputError(
                f"cloth: gap = {self.gap} m, must be 0 or between the spacing and twice the spacing {self.spacing}; "
                "change it or the number of vertices"
            )
        if self.contact_columns < 0:
            raise InputError(f"cloth: contact_columns = {self.contact_columns}, must be >= 0; change it")
        for name in ("substeps", "air_substeps"):
            if getattr(self, name) < 1:
                raise InputError(f"cloth: {name} = {getattr(self, name)}, must be 1 or more; change it")


class Cloth:
    """A rectangular cloth in motion; vertex (i, j) is row i (down yarn 2), column j (along yarn 1).

    Buffers for other passes, one vec4 a vertex in row-major order: `position_buffer` (w = inverse mass, 0 = pinned),
    `normal_buffer`, `tangent_buffer` (w = 1), the last two after `update_frames()`.
    """

    # Self-contact lists are made every so many substeps, and hold what is nearer than LIST_REACH gaps.
    LIST_SUBSTEPS = 4
    ROW_LIST_SUBSTEPS = 6
    LIST_REACH = 1.6

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

        Raises InputError for fewer than 3 x 3 vertices and for positions that are not finite.
        """
        positions = np.asarray(positions, np.float64)
        if positions.ndim != 3 or positions.shape[2] != 3 or min(positions.shape[:2]) < 3:
            raise InputError(f"cloth: positions have shape {positions.shape}, expected [rows >= 3, columns >= 3, 3]")
        if not np.isfinite(positions).all():
            raise InputError("cloth: positions must be finite; mend the starting shape")
        self.ctx = ctx
        self.parameters = parameters
        self.rows, self.columns = positions.shape[:2]
        self.vertex_count = self.rows * self.columns
        self.quad_count = (self.rows - 1) * (self.columns - 1)
        self.table_size = 1 << max(8, (2 * self.vertex_count - 1).bit_length())
        self.wind = wind or Wind()
        self.time = 0.0
        self.substeps_done = 0
        self._programs: dict[tuple, moderngl.ComputeShader] = {}
        self.inverse_mass = 1.0 / self._masses()
        if pinned is not None:
            self.inverse_mass[np.asarray(pinned, bool)] = 0.0
        V = self.vertex_count
        # Four-byte words of each buffer, by the name of its block in the passes.
        words = {"Position": 4 * V, "Previous": 4 * V, "Velocity": 4 * V, "Air": 4 * V, "AirForce": 8 * self.quad_count}
        words |= {"Eliminated": 2 * V, "Normal": 4 * V, "Tangent": 4 * V, "Contact": 4 * V if parameters.gap else 4}
        if parameters.gap and not parameters.contact_columns:
            words |= {"Count": self.table_size, "Begin": self.table_size, "Cursor": self.table_size, "Member": V}
        if parameters.gap:
            words |= {"Near": V * CONSTANTS["MAX_NEAR"], "NearCount": V, "Overflow": 1}
        self._fetched = {
            name: TextureBuffer(ctx, bytes(4 * words[name]), texel) for name, texel in FETCHED.items() if name in words
        }
        self._buffers = {
            name: self._fetched[name].buffer if name in FETCHED else ctx.buffer(bytes(4 * count))
            for name, count in words.items()
        }
        self.position_buffer = self._buffers["Position"]
        self.normal_buffer = self._buffers["Normal"]
        self.tangent_buffer = self._buffers["Tangent"]
        self.set_state(positions)
        self.set_colliders(colliders)

    def _masses(self) -> np.ndarray:
        """Return [rows, columns] kg: the area that is nearest to each vertex, times the mass per area."""
        share_u, share_v = np.ones(self.columns), np.ones(self.rows)
        share_u[[0, -1]] = share_v[[0, -1]] = 0.5
        share_v[-1] *= self.parameters.hem
        return np.outer(share_v, share_u) * math.prod(self.parameters.spacing) * self.parameters.mass

    def set_colliders(self, colliders: Sequence[Solid]) -> None:
        """Replace the solids. Raises InputError for shapes that make no sense."""
        self.colliders = tuple(colliders)
        self._solids = _solids_glsl(self.colliders)
        for key in [key for key in self._programs if key[0] == "advance"]:
            self._programs.pop(key).release()

    def _program(self, name: str, defines: dict | None = None, virtual: dict | None = None) -> moderngl.ComputeShader:
        key = (name, *(defines or {}).values())
        if key not in self._programs:
            self._programs[key] = shader.compute(self.ctx, f"passes/simulation/{name}.comp", defines, virtual)
        return self._programs[key]

    def _run(self, program: moderngl.ComputeShader, blocks: str, invocations: int, group: int = 64, **uniforms) -> None:
        """Dispatch a pass whose bindings 0, 1, ... are the named blocks; make what it wrote visible to the next.

        A block with a ~ before its name is fetched from the texture unit of that number.
        """
        for binding, block in enumerate(blocks.split()):
            if block[0] == "~":
                self._fetched[block[1:]].bind(binding)
            else:
                self._buffers[block].bind_to_storage_buffer(binding)
        shader.set_uniforms(program, **uniforms)
        program.run(-(-invocations // group))
        self.ctx.memory_barrier()

    def step(self, dt: float) -> moderngl.Buffer:
        """Advance by dt seconds in `parameters.substeps` equal substeps; return `position_buffer`."""
        for _ in self.steps(dt):
            pass
        return self.position_buffer

    def steps(self, dt: float) -> Iterator[None]:
        """As `step`, for a caller with other things to do in between: yields after every `air_substeps` substeps."""
        if not (dt > 0 and math.isfinite(dt)):
            raise InputError(f"cloth: time step {dt} s, must be > 0; change it")
        m = self.parameters
        h = dt / m.substeps
        # Faster than half a gap in a substep, and two layers could change sides unseen.
        limit = min(m.speed_limit, 0.5 * m.gap / h) if m.gap else m.speed_limit
        values = {
            "vertex_count": self.vertex_count, "h": h, "gravity": m.gravity, "speed_limit": limit,
            "thickness": m.thickness, "mu": m.friction, "keep": math.exp(-m.damping * h),
        }  # fmt: skip
        finish, both, begin = (self._advance(*ends, values) for ends in ((1, 0), (1, 1), (0, 1)))
        for k in range(m.substeps):
            # The air changes slowly: its force serves several substeps, limited as one step of that length.
            if k % m.air_substeps == 0:
                if k > 0:
                    self._run(finish, ADVANCE, self.vertex_count)
                    yield
                if max(m.drag) > 0:
                    self._air(h * min(m.air_substeps, m.substeps - k))
                self._run(begin, ADVANCE, self.vertex_count)
            else:
                self._run(both, ADVANCE, self.vertex_count)
            self._constraints(h)
            self.time += h
            self.substeps_done += 1
        self._run(finish, ADVANCE, self.vertex_count)
        yield

    def _advance(self, finish: int, begin: int, values: dict) -> moderngl.ComputeShader:
        """Return the pass between two substeps with its uniforms set."""
        defines = {"FINISH": finish, "BEGIN": begin, "CONTACT": int(self.parameters.gap > 0)}
        program = self._program("advance", defines, {"solids.glsl": self._solids})
        shader.set_uniforms(program, **values)
        return program

    def _air(self, duration: float) -> None:
        m = self.parameters
        grid = {"rows": self.rows, "columns": self.columns}
        self._run(
            self._program("wind"), "~Position ~Velocity AirForce", self.quad_count, h=duration, time=self.time,
            wind=self.wind.velocity, gustiness=self.wind.gustiness, C_n=m.drag[0], C_t=m.drag[1],
            triangle_mass=0.5 * math.prod(m.spacing) * m.mass, **grid,
        )  # fmt: skip
        self._run(self._program("air"), "~Position Air ~AirForce", self.vertex_count, **grid)

    def _constraints(self, h: float) -> None:
        m = self.parameters
        rest_u, rest_v = m.spacing
        backward = self.substeps_done & 1
        for parity in (0, 1):
            self._run(
                self._program("strips"), "Position", self.rows // 2, group=8, parity=parity, backward=backward,
                rows=self.rows, columns=self.columns, rest=math.hypot(rest_u, rest_v),
                shear_h2=_compliance(m.shear, h),
            )  # fmt: skip
        # The spring of one cell: a sheet of stiffness k N/m, as wide as the cell, over the cell's length.
        rows = (self.rows, self.columns, self.columns, 1, rest_u, rest_v)
        columns = (self.columns, self.rows, 1, self.columns, rest_v, rest_u)
        for lines, count, line_stride, stride, rest, width in (columns, rows) if m.rows_last else (rows, columns):
            self._run(
                self._program("lines"), "Position Eliminated", lines, group=8, lines=lines, count=count,
                line_stride=line_stride, stride=stride, backward=backward, rest=rest,
                stretch_h2=_compliance(m.stretch * width / rest, h),
                bend_h2=_compliance(m.bending * width / rest**3, h),
            )  # fmt: skip
        if m.gap:
            self._contact(self.vertex_count)

    def _contact(self, V: int) -> None:
        m = self.parameters
        reach = self.LIST_REACH * m.gap
        if m.contact_columns and self.substeps_done % self.ROW_LIST_SUBSTEPS == 0:
            self._run(
                self._program("near_rows"), "~Position Near NearCount Overflow", V, vertex_count=V,
                columns=self.columns, window=m.contact_columns, reach=reach,
            )  # fmt: skip
        elif not m.contact_columns and self.substeps_done % self.LIST_SUBSTEPS == 0:
            table = {"table_size": self.table_size, "cell_size": reach, "vertex_count": V}
            self._run(self._program("count"), "Position Count", V, **table)
            self._run(self._program("scan"), "Count Begin Cursor", 1, **table)
            self._run(self._program("fill"), "Position Cursor Member", V, **table)
            self._run(self._program("sort"), "Begin Cursor Member", self.table_size, **table)
            near = "Position Begin Cursor Member Near NearCount Overflow"
            self._run(self._program("near"), near, V, columns=self.columns, **table)
        contact = "~Position ~Previous Contact ~Near ~NearCount"
        self._run(self._program("contact"), contact, V, vertex_count=V, gap=m.gap, mu=m.friction)

    def update_frames(self) -> None:
        """Compute `normal_buffer` and `tangent_buffer` from the present positions."""
        grid = {"rows": self.rows, "columns": self.columns}
        self._run(self._program("normals"), "~Position Normal Tangent", self.vertex_count, **grid)

    def _read(self, buffer: moderngl.Buffer, width: int = 3) -> np.ndarray:
        data = np.frombuffer(buffer.read(), np.float32).reshape(self.rows, self.columns, 4)
        return data[..., :width].copy()

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
        self.position_buffer.write(state.tobytes())
        state[:] = 0
        if velocities is not None:
            state[:, :3] = np.asarray(velocities).reshape(-1, 3)
        self._buffers["Velocity"].write(state.tobytes())

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
        kept = [buffer for name, buffer in self._buffers.items() if name not in self._fetched]
        for thing in (*kept, *self._fetched.values(), *self._programs.values()):
            thing.release()
        self._fetched.clear()
        self._buffers.clear()
        self._programs.clear()


def _compliance(stiffness: float, h: float) -> float:
    """Return 1 / (k h^2), kg^-1, of a spring of k N/m; a spring of no stiffness gives without end (1e30)."""
    return min(1e30, 1.0 / (stiffness * h * h)) if stiffness > 0 else 1e30


def _solids_glsl(colliders: Sequence[Solid]) -> str:
    """Return the GLSL that resolves a point against each solid in turn; their numbers become constants."""
    calls = []
    for solid in colliders:
        if isinstance(solid, Plane):
            length = math.hypot(*solid.normal)
            if not length > 0:
                raise InputError(f"plane: normal {solid.normal} has no direction; give another")
            normal = [c / length for c in solid.normal]
            calls.append(f"d_plane(point, {_glsl(normal)}, {_glsl(solid.offset / length)})")
        elif isinstance(solid, Sphere):
            if not solid.radius > 0:
                raise InputError(f"sphere: radius {solid.radius} must be > 0; change it")
            calls.append(f"d_sphere(point, {_glsl(solid.center)}, {_glsl(solid.radius)})")
        else:
            if not 0 <= solid.rounding <= min(solid.half_size):
                raise InputError(
                    f"box: rounding {solid.rounding} must lie between 0 and the least half side; change it"
                )
            calls.append(f"d_box(point, {_glsl(solid.center)}, {_glsl(solid.half_size)}, {_glsl(solid.rounding)})")
    lines = [f"    point = resolve(point, before, {call});" for call in calls]
    return "\n".join(["vec3 resolve_solids(vec3 point, vec3 before) {", *lines, "    return point;", "}", ""])


def _glsl(value: float | Sequence[float]) -> str:
    """Return a GLSL constant for a number, or for three of them."""
    if isinstance(value, (int, float)):
        return f"{value:.9e}"
    return "vec3(" + ", ".join(_glsl(float(c)) for c in value) + ")"
