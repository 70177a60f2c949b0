"""Cloths that touch each other: none passes through another, and what one is pushed by, it pushes back.

In each substep the vertices of all move first by their own constraints; then each is parted from the near vertices of the others,
by its share of the push as the masses say, and all begin the next substep together.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import moderngl

from ..gpu.buffers import Buffer, TextureBuffer
from ..gpu.programs import programs
from .cloth import CONSTANTS, Cloth, steps_together


class Meeting:
    """Cloths that may touch each other: none passes through another, and a push moves both as their masses ask for.

    Each vertex keeps a gap from the vertices of the others, as from those of its own cloth: from all at once, as they are before
    any of them moves, so the result does not depend on an order.
    """

    def __init__(self, ctx: moderngl.Context, sides: tuple[Sequence[Cloth], Sequence[Cloth]], gap: float):
        """`sides`: cloths of one may meet those of the other. `gap`: kept between vertices, m; more than half the diagonal of
        any cloth's cells."""
        self.ctx, self.gap = ctx, gap
        self.cloths = [*sides[0], *sides[1]]
        number = {id(cloth): k for k, cloth in enumerate(self.cloths)}
        pairs = [(one, other) for one in sides[0] for other in sides[1]]
        self._pairs = [(number[id(a)], number[id(b)]) for one, other in pairs for a, b in ((one, other), (other, one))]
        self._met = [Buffer(ctx, bytes(16 * cloth.vertex_count)) for cloth in self.cloths]
        self._near = [
            {
                "Near": TextureBuffer(ctx, bytes(4 * CONSTANTS["MAX_NEAR"] * self.cloths[one].vertex_count), "r32i"),
                "NearCount": TextureBuffer(ctx, bytes(4 * self.cloths[one].vertex_count), "r32i"),
            }
            for one, _ in self._pairs
        ]
        self._age = 0

    def steps(self, dt: float) -> Iterator[None]:
        """Advance all; as `Cloth.steps`."""
        self._age = 0
        yield from steps_together(self.cloths, dt, self)

    def contacts(self, mu: float) -> list[dict[str, Any]]:
        """Find the contacts between the cloths as they are now: what the contact pass of each takes."""
        if self._age % Cloth.ROW_LIST_SUBSTEPS == 0:
            self._list()
        self._age += 1
        meet = programs(self.ctx).compute("passes/simulation/meet.comp")
        begun: set[int] = set()
        for (one, other), near in zip(self._pairs, self._near, strict=True):
            here, there = self.cloths[one], self.cloths[other]
            meet.run(
                here.vertex_count, here._buffers, here._sizes, near, Met=self._met[one], OtherPosition=there._buffers["Position"],
                OtherPrevious=there._buffers["Previous"], begins=one not in begun, gap=self.gap, mu=mu,
            )  # fmt: skip
            begun.add(one)
        return [{"Met": met} for met in self._met]

    def _list(self) -> None:
        """List for each vertex the near ones of the other cloths; the lists serve several substeps."""
        reach = Cloth.LIST_REACH * self.gap
        cells = [cloth._sort_into_cells(reach) for cloth in self.cloths]
        near = programs(self.ctx).compute("passes/simulation/near.comp", {"OTHER": 1})
        for (one, other), lists in zip(self._pairs, self._near, strict=True):
            here = self.cloths[one]
            near.run(
                here.vertex_count, here._buffers, here._sizes, cells[other], lists, cell_size=reach,
                OtherPosition=self.cloths[other].position_buffer,
            )  # fmt: skip

    def release(self) -> None:
        """Free the GPU's memory, but not the cloths'."""
        for buffer in self._met:
            buffer.release()
        for lists in self._near:
            for buffer in lists.values():
                buffer.release()
