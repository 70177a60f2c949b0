"""A plan that is drawn slice by slice within a time budget, so that the window always answers."""

from __future__ import annotations

import time
from collections.abc import Iterator

BUDGET = 0.026  # seconds between two looks at the input that are aimed at, so that they are rarely 0.033


class Slices:
    """What draws so: `_all` yields after each slice whether something new is to be seen. It is to set `_refining` once
    the small picture that answers the last edit is there, and to begin again where it finds `_again` set before."""

    caution = 0.7  # how much of the last slice's time must be left for the next one

    def __init__(self):
        self._plan: Iterator[bool] | None = None
        self._refining = self._again = False
        self._until = 0.0

    @property
    def idle(self) -> bool:
        """True when all that is to be seen is complete."""
        return self._plan is None

    @property
    def previewing(self) -> bool:
        """True while a picture is on its way that answers what was done last."""
        return self._plan is not None and not self._refining

    def _begin(self) -> None:
        """Draw anew. A small picture under way is finished first: else the edits of a drag, one after the other, would let
        none be seen."""
        if self.previewing:
            self._again = True
        else:
            self._plan = None  # first: what the old plan holds on to is let go
            self._plan = self._all()

    def work(self, budget: float = BUDGET) -> bool:
        """Draw for about `budget` seconds; True when what is to be seen has changed."""
        if self._plan is None:
            return False
        changed = False
        self._until = time.perf_counter() + budget
        try:
            while True:
                begin = time.perf_counter()
                changed |= next(self._plan)
                if changed and self.previewing:
                    return True  # the answer is shown before anything else is drawn
                now = time.perf_counter()
                # The next slice is likely as long as this one; it must end in time too.
                if now + self.caution * (now - begin) >= self._until:
                    return changed
        except StopIteration:
            self._plan = None
            return changed
        except BaseException:
            self._plan = None
            raise

    def _all(self) -> Iterator[bool]:
        raise NotImplementedError
