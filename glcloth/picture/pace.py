"""How fast a frame is drawn: all at once, or in parts, for a caller with other things to do in between."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import Any

import moderngl

from ..progress import track

BAND_PIXELS = 120_000  # of the G-buffer at a time
SLICE = 0.012  # seconds of rays from pixels at a time
PATIENCE = 0.1  # likewise, where nobody but Ctrl-C waits


@dataclass(frozen=True)
class Pace:
    """How a frame is drawn.

    Parameters
    ----------
    rows : called before each part: how many rows of the picture it may shade; None: all at once
    preview : make do with the shadows as far as they are known
    announce : text of a progress bar; None: no bar
    """

    rows: Callable[[], int] | None = None
    preview: bool = False
    announce: str | None = None

    def bands(self, height: int, factor: int = 1) -> Iterator[tuple[int, int] | None]:
        """(first row, how many) of each part of a picture, `factor` times as many as `rows` says; None, once, for all."""
        if self.rows is None:
            yield None
            return
        first = 0
        while first < height:
            count = max(1, min(factor * self.rows(), height - first))
            yield first, count
            first += count

    def pause(self, ctx: moderngl.Context) -> Iterator[None]:
        """Between two parts: wait for the GPU and yield, where a caller waits."""
        if self.rows is not None:
            ctx.finish()
            yield

    def draw_rows(self, size: tuple[int, int]) -> int:
        """Rows of the G-buffer to draw at a time."""
        return size[1] if self.rows is None else max(1, BAND_PIXELS // size[0])

    @property
    def slice(self) -> float:
        """Seconds of rays from pixels at a time."""
        return PATIENCE if self.rows is None else SLICE

    def tracked(self, items: Iterable[Any], what: str, total: int | None = None) -> Iterable[Any]:
        """The items, with a progress bar where one is wanted."""
        return track(items, what, total) if self.announce else items
