"""A plan that is drawn slice by slice within a time budget, so that the window always answers."""

from __future__ import annotations

from collections.abc import Iterator

from .clock import now
from .pictures import Side

BUDGET = 0.026  # seconds between two looks at the input that are aimed at, so that they are rarely 0.033


class Slices:
    """The base of drawers that work in slices. `sides` hold the pictures.

    `_all` yields after each slice whether something new is to be seen. It sets `_refining` once the small picture that
    answers the last edit is there, and begins again where it finds `_again` set before that.
    """

    caution = 0.7  # how much of the last slice's time must be left for the next one

    def __init__(self) -> None:
        self.sides: list[Side] = []
        self.full_ms = 0.0  # from the last edit to the complete picture
        self._plan: Iterator[bool] | None = None
        self._refining = self._again = False
        self._begun = self._until = 0.0

    @property
    def idle(self) -> bool:
        """True when all pictures are complete."""
        return self._plan is None

    @property
    def previewing(self) -> bool:
        """True while a picture is on its way that answers the last edit."""
        return self._plan is not None and not self._refining

    def _begin(self, sides: int) -> None:
        """Draw so many sides anew. A small picture under way is finished first: else the edits of a drag, one after the
        other, would let none be seen."""
        self.sides = [*self.sides, Side(), Side()][:sides]
        for side in self.sides:
            side.share = 0.0
        self._begun = now()
        if self.previewing:
            self._again = True
        else:
            self._plan = None  # first: the old plan lets go of all it holds
            self._plan = self._all()

    def work(self, budget: float = BUDGET) -> bool:
        """Draw for about `budget` seconds; True when the picture has changed."""
        if self._plan is None:
            return False
        changed = False
        self._until = now() + budget
        try:
            while True:
                begin = now()
                changed |= next(self._plan)
                if changed and self.previewing:
                    return True  # the answer is shown before anything else is drawn
                end = now()
                # The next slice is likely as long as this one; it must end in time too.
                if end + self.caution * (end - begin) >= self._until:
                    return changed
        except StopIteration:
            self._plan = None
            self.full_ms = 1e3 * (now() - self._begun)
            return changed
        except BaseException:
            self._plan = None
            raise

    def finish(self) -> None:
        """Draw until all is at full quality."""
        while not self.idle:
            self.work(10.0)

    def _all(self) -> Iterator[bool]:
        raise NotImplementedError


def refining(side: Side) -> str:
    """How far a picture is, in tenths, so that the line stays calm."""
    return f"refining {10 * int(10 * side.share)} %" + (f", shown at 1/{side.scale:g}" if side.scale > 1 else "")
