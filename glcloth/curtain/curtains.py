"""The curtains of a window: one, or a pair that is drawn apart, and another one behind, nearer the window."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import moderngl
import numpy as np

from ..geometry.mesh import Mesh, build_mesh
from ..scene import CurtainParameters
from ..simulation.backdrop import Backdrop
from ..simulation.meeting import Meeting
from .hanging import CLOSED, CurtainSimulation, gusts, pleated_rail

BETWEEN = 0.03  # m, between the folds of two curtains at rest
FRONT, BEHIND = 0, 1  # numbers of curtains, and of their fabrics


@dataclass(frozen=True)
class Panel:
    """A piece of cloth on the rail: how it hangs, by how much its middle is off that of the window along x, and whose it is."""

    parameters: CurtainParameters
    shift: float
    curtain: int


def panels_of(m: CurtainParameters, behind_openness: float = 0.0) -> list[Panel]:
    """The pieces of cloth that parameters ask for, those of the front curtain first."""
    one = m.changed(open=0.0, behind="", behind_open=0.0)
    if not m.behind:
        return _pieces(one, m.open, FRONT)
    behind = one.changed(fullness=m.behind_fullness, mass=m.behind_mass, openness=behind_openness)
    z = pleated_rail(behind, behind.quads[0] + 1)[:, 1]
    # Only what the curtain behind lets through, or by, still blows.
    passed = 1.0 - (1.0 - behind_openness) * (1.0 - m.behind_open / m.width)
    front = one.changed(clearance=float(z.max()) + BETWEEN, wind=m.wind * passed)
    return _pieces(front, m.open, FRONT) + _pieces(behind, m.behind_open, BEHIND)


def _pieces(m: CurtainParameters, apart: float, curtain: int) -> list[Panel]:
    if not apart:
        return [Panel(m, 0.0, curtain)]
    width = (m.width - apart) / 2
    share = width / m.width
    said: dict[str, Any] = {"width": width}
    if "pleats" in m.model_fields_set:
        said["pleats"] = max(1, round(m.pleats * share))
    if "quads" in m.model_fields_set:
        across = max(6, round(m.quads[0] * share))
        said["quads"] = across, m.quads[1]
        said["pleats"] = max(1, min(round(m.pleats * share), across // 6))
    half = m.changed(**said)
    off = (m.width - width) / 2
    return [Panel(half, -off, curtain), Panel(half, off, curtain)]


class Curtains:
    """All pieces of cloth before a window in motion. What the front one is, is asked as of a CurtainSimulation."""

    def __init__(
        self,
        ctx: moderngl.Context,
        parameters: CurtainParameters | None = None,
        settle: bool = True,
        behind_openness: float = 0.0,
    ):
        """As CurtainSimulation; `behind_openness`: share of the second curtain that lets air through."""
        self.parameters = m = parameters or CurtainParameters()
        self.panels = panels_of(m, behind_openness)
        self.pieces: list[CurtainSimulation] = []
        self.backdrop: Backdrop | None = None
        self.meeting: Meeting | None = None
        try:
            for panel in self.panels:
                self.pieces.append(CurtainSimulation(ctx, panel.parameters, False, panel.shift))
            if behind := self.pieces_of(BEHIND):
                x, low = m.width / 2, m.upper - m.drop
                cell = max(max(one.cloth.parameters.spacing) for one in behind)
                self.backdrop = Backdrop(ctx, [one.cloth for one in behind], cell, (-x, low - 0.2), (x, m.upper + 0.2))
                for one in self.pieces_of(FRONT):
                    one.cloth.hang_before(self.backdrop)
            self._push()
            for _ in self.settling() if settle else ():
                pass
        except BaseException:
            self.release()
            raise

    def pieces_of(self, curtain: int) -> list[CurtainSimulation]:
        """Those of a curtain, FRONT or BEHIND."""
        return [one for one, panel in zip(self.pieces, self.panels, strict=True) if panel.curtain == curtain]

    def settling(self) -> Iterator[float]:
        """As that of a CurtainSimulation: those behind first."""
        order = self.pieces_of(BEHIND) + self.pieces_of(FRONT)
        for k, one in enumerate(order):
            if k == len(self.pieces_of(BEHIND)) > 0:
                self._take()
            for share in one.settling():
                yield (k + share) / len(order)
        self._take()

    def steps(self, dt: float) -> Iterator[None]:
        """As those of a CurtainSimulation: those behind first, and then those before, as far as they are kept out.

        In strong wind all together, as they push each other.
        """
        meets = self.backdrop is not None and any(one.strong for one in self.pieces)
        wanted = None if meets else self.backdrop
        for one in self.pieces_of(FRONT):
            if one.cloth.backdrop is not wanted:
                one.cloth.hang_before(wanted)
        if meets:
            yield from self._together(dt)
            return
        for one in self.pieces_of(BEHIND):
            yield from one.steps(dt)
        if self.backdrop is not None:
            self.backdrop.take()
        for one in self.pieces_of(FRONT):
            yield from one.steps(dt)

    def _together(self, dt: float) -> Iterator[None]:
        """Advance all, substep by substep, with contact between those before and those behind."""
        if self.meeting is None:
            gap = max(CLOSED * math.hypot(*one.cloth.parameters.spacing) / 2 for one in self.pieces)
            sides = [one.cloth for one in self.pieces_of(FRONT)], [one.cloth for one in self.pieces_of(BEHIND)]
            self.meeting = Meeting(self.pieces[0].cloth.ctx, sides, gap)
        substeps = max(one.substeps(dt) for one in self.pieces)
        for one in self.pieces:
            one.take_substeps(substeps)
        yield from self.meeting.steps(dt)
        for one in self.pieces:
            one.cloth.update_frames()
        self._take()

    def _take(self) -> None:
        """Those behind hang still where they are."""
        if self.backdrop is not None:
            self.backdrop.take()
            self.backdrop.take()

    def _push(self) -> None:
        """Those before move with those behind, and need as many substeps."""
        wind = max((gusts(one.parameters) for one in self.pieces_of(BEHIND)), default=0.0)
        for one in self.pieces_of(FRONT):
            one.pushed = wind

    def step(self, dt: float) -> None:
        """Advance by dt seconds."""
        for _ in self.steps(dt):
            pass

    def change(self, parameters: CurtainParameters, behind_openness: float = 0.0) -> bool:
        """Take other parameters while they move; False, and nothing done, where they must be hung anew for them."""
        panels = panels_of(parameters, behind_openness)
        same = [(panel.shift, panel.curtain) for panel in panels] == [(p.shift, p.curtain) for p in self.panels]
        if not same or not all(
            one.can_change(panel.parameters) for one, panel in zip(self.pieces, panels, strict=True)
        ):
            return False
        for one, panel in reversed(list(zip(self.pieces, panels, strict=True))):
            one.change(panel.parameters)
            self._push()
        self.parameters, self.panels = parameters, panels
        return True

    # -- of the front one ------------------------------------------------------------------------------------------

    @property
    def cloth(self):
        """The simulated cloth."""
        return self.pieces[0].cloth

    @property
    def rows(self) -> int:
        """Of vertices."""
        return self.pieces[0].rows

    @property
    def columns(self) -> int:
        """Of vertices."""
        return self.pieces[0].columns

    @property
    def time(self) -> float:
        """Seconds since the wind began."""
        return self.pieces[0].time

    def positions(self) -> np.ndarray:
        """Return [rows, columns, 3] float32, m."""
        return self.pieces[0].positions()

    # -- of all ----------------------------------------------------------------------------------------------------

    @property
    def triangle_counts(self) -> list[int]:
        """Of each piece."""
        return [2 * (one.rows - 1) * (one.columns - 1) for one in self.pieces]

    def first_of(self, curtain: int) -> int:
        """The first triangle of a curtain, among those of all; their number, where there is none."""
        before = [n for n, panel in zip(self.triangle_counts, self.panels, strict=True) if panel.curtain < curtain]
        return sum(before)

    @property
    def has_behind(self) -> bool:
        """Whether there is a second curtain."""
        return any(panel.curtain == BEHIND for panel in self.panels)

    def meshes(self) -> list[Mesh]:
        """The present shape of each curtain."""
        return [
            joined([one.mesh() for one in self.pieces_of(number)], name)
            for number, name in ((FRONT, "curtain"), (BEHIND, "curtain behind"))
            if self.pieces_of(number)
        ]

    def mesh(self) -> Mesh:
        """The present shape of all."""
        return joined(self.meshes(), "curtain")

    def release(self) -> None:
        """Free the GPU's memory."""
        for one in self.pieces:
            one.release()
        if self.backdrop is not None:
            self.backdrop.release()
        if self.meeting is not None:
            self.meeting.release()


def joined(meshes: list[Mesh], name: str) -> Mesh:
    """One mesh of several with UVs."""
    if len(meshes) == 1:
        return meshes[0]
    begins = np.cumsum([0, *(len(mesh.positions) for mesh in meshes[:-1])])
    triangles = np.concatenate([mesh.triangles + begin for mesh, begin in zip(meshes, begins, strict=True)])
    positions, uv, normals = (
        np.concatenate([getattr(mesh, field) for mesh in meshes]) for field in ("positions", "uv", "normals")
    )
    return build_mesh(name, positions, triangles, uv, normals)
