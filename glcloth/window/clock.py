"""The one clock of the window: the time, how long ago things happened, and how long a step takes."""

from __future__ import annotations

import time
from collections.abc import Iterable, Iterator
from typing import TypeVar

T = TypeVar("T")
WAKE = 3  # pictures of the panels after an event: hovering and fading settle within these

now = time.perf_counter  # seconds


def timed(steps: Iterable[T]) -> Iterator[tuple[T, float]]:
    """Each step of a generator with the seconds that it took; time between two steps does not count."""
    steps = iter(steps)
    while True:
        begin = now()
        try:
            value = next(steps)
        except StopIteration:
            return
        yield value, now() - begin


class Clock:
    """Moments and durations by name, and how many more times the panels are to be drawn."""

    def __init__(self) -> None:
        self.awake = WAKE
        self._moments: dict[str, float] = {}
        self._usual: dict[str, float] = {}

    def wake(self, pictures: int = WAKE) -> None:
        """Draw the panels so many times, at least."""
        self.awake = max(self.awake, pictures)

    def heard(self) -> None:
        """The user did something."""
        self.mark("heard")
        self.wake()

    def mark(self, moment: str) -> None:
        """It is now."""
        self._moments[moment] = now()

    def since(self, moment: str) -> float:
        """Seconds since a moment; without end before the first."""
        return now() - self._moments.get(moment, float("-inf"))

    def every(self, seconds: float, moment: str) -> bool:
        """True, and marked, once in so many seconds."""
        due = self.since(moment) >= seconds
        if due:
            self.mark(moment)
        return due

    def learn(self, what: str, seconds: float) -> None:
        """It took so long this time."""
        self._usual[what] = self.usual(what) + 0.2 * (seconds - self.usual(what))

    def usual(self, what: str) -> float:
        """How long it usually takes."""
        return self._usual.get(what, 0.005)
