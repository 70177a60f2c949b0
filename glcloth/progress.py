"""Progress of long work, on stderr; silent when stderr is not a terminal or the work is done within a second."""

from __future__ import annotations

import signal
import sys
import time
from collections.abc import Iterable, Iterator, Sized
from typing import TypeVar

from .errors import limited, printable

T = TypeVar("T")
_stopped = False
_quiet = False
BAR_AFTER = 1.0  # seconds of work after which a terminal shows a bar
SAY_EVERY = 10.0  # seconds between two lines elsewhere


def hear_ctrl_c() -> None:
    """From now on Ctrl-C raises KeyboardInterrupt, and is remembered if somebody's `except:` swallows it."""

    def stop(*_):
        global _stopped
        _stopped = True
        raise KeyboardInterrupt

    signal.signal(signal.SIGINT, stop)


def was_stopped() -> bool:
    """True once Ctrl-C was pressed."""
    return _stopped


def check_stopped() -> None:
    """Raise KeyboardInterrupt if Ctrl-C was pressed and a library that was being imported swallowed it."""
    if _stopped:
        raise KeyboardInterrupt


def be_quiet(quiet: bool) -> None:
    """Whether from now on only errors and results are printed: no progress, no warnings, no notes."""
    global _quiet
    _quiet = quiet


def drain(steps: Iterable) -> None:
    """Go through all steps of some work at once."""
    for _ in steps:
        pass


class Stopwatch:
    """Milliseconds that the stages of some work took: `ms`, by their names."""

    def __init__(self):
        self.ms: dict[str, float] = {}
        self.resume()

    def resume(self) -> None:
        """The next stage begins now."""
        self._begin = time.perf_counter()

    def lap(self, stage: str) -> None:
        """A stage ends, and the next begins."""
        begin = self._begin
        self.resume()
        self.ms[stage] = 1000 * (self._begin - begin)


def track(items: Iterable[T], what: str, total: int | None = None) -> Iterator[T]:
    """Yield `items`, and after one second show a bar that says `what` is being done.

    On a terminal it is a live bar; elsewhere one line every ten seconds, so that a log still shows life.
    """
    if total is None:
        total = len(items) if isinstance(items, Sized) else None
    begin = said = time.monotonic()
    terminal = sys.stderr.isatty()
    bar = None
    task = None
    try:
        for done, item in enumerate(items):
            check_stopped()
            now = time.monotonic()
            if terminal:
                if bar is None and now - begin > BAR_AFTER and not _quiet:
                    bar = _bar()
                    task = bar.add_task(printable(what), total=total)
                    bar.start()
                if bar is not None:
                    bar.update(task, completed=done)
            elif now - said > SAY_EVERY:
                said = now
                note(f"glcloth: {what}: {done}{f' of {total}' if total is not None else ''}")
            yield item
    finally:
        if bar is not None:
            bar.stop()


def _bar():
    """A bar on stderr."""
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    columns = TextColumn("{task.description}", markup=False), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn()
    return Progress(*columns, console=Console(stderr=True), transient=True)


def say(line: str) -> None:
    """Print one line on stderr, printable and at most 300 characters long; all errors and warnings go through here."""
    print(limited(printable(line)), file=sys.stderr, flush=True)


def note(line: str) -> None:
    """Say what nobody has to know: progress, warnings, what was written; nothing where one asked for quiet."""
    if not _quiet:
        say(line)


def show(lines: Iterable[str]) -> None:
    """Print a result for people on stdout, line by line; names in it are made printable."""
    for line in lines:
        encoding = sys.stdout.encoding or "utf-8"
        print(printable(line).encode(encoding, "replace").decode(encoding), flush=True)


_warned: set[str] = set()


def warn(line: str) -> None:
    """Print one warning on stderr; the same line is said once per process."""
    if line not in _warned:
        _warned.add(line)
        note(f"glcloth: warning: {line}")
