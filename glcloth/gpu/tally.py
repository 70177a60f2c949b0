"""What a context was asked to do: dispatches, and read-backs that the CPU waits for."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

import moderngl

from .context_local import of_context


@dataclass
class Counted:
    """Counts of some work. reads, read_bytes : what the CPU waited for. dispatches : of compute passes, by the paths of
    these; indirect ones too, whose size the GPU alone knows. fewest : the least invocations of a dispatch, by path."""

    reads: int = 0
    read_bytes: int = 0
    dispatches: dict[str, int] = field(default_factory=dict)
    fewest: dict[str, int] = field(default_factory=dict)

    @property
    def dispatched(self) -> int:
        """How many dispatches in all."""
        return sum(self.dispatches.values())

    def dispatch(self, path: str, items: int | None = None) -> None:
        """Count a dispatch of so many invocations with work; None: indirect."""
        self.dispatches[path] = self.dispatches.get(path, 0) + 1
        if items is not None:
            self.fewest[path] = min(items, self.fewest.get(path, items))


class Tally:
    """Who counts on one context; nobody at first, and then a dispatch or read costs one look at a list."""

    def __init__(self, ctx: moderngl.Context):
        self.open: list[Counted] = []

    def dispatch(self, path: str, items: int | None) -> None:
        """Count a dispatch."""
        for counted in self.open:
            counted.dispatch(path, items)

    def read(self, size: int) -> None:
        """Count a read-back of so many bytes."""
        for counted in self.open:
            counted.reads += 1
            counted.read_bytes += size


@contextmanager
def counting(ctx: moderngl.Context) -> Iterator[Counted]:
    """Count what a context is asked to do within."""
    tally, counted = of_context(Tally, ctx), Counted()
    tally.open.append(counted)
    try:
        yield counted
    finally:
        # Two of equal counts are equal: by identity.
        tally.open[:] = [other for other in tally.open if other is not counted]
