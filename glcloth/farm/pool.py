"""Processes on this machine that share a job, picture by picture; one that dies costs its picture, which another makes.

They are forked from one that has loaded glcloth and has never touched OpenGL, so that none of them loads it again.

A job has `pictures(numbers)`, which yields the pictures of ascending numbers, `write(number, picture)`, which gives a
plain result, and `file(number)`. It travels to the processes by pickle.
"""

from __future__ import annotations

import contextlib
import heapq
import io
import multiprocessing
import os
import signal
import sys
import threading
import traceback
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from multiprocessing import forkserver
from multiprocessing.connection import Connection, wait
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from threadpoolctl import threadpool_limits

from ..errors import DriverError, InputError, NoOpenGLError, ShaderError
from ..progress import warn

DEATHS = 3  # of the processes that had a picture in hand, until the picture is given up
WARNING = "glcloth: warning: "
# What the process that others are forked from loads, once for all of them.
LOADED = ["glcloth.farm.film", "glcloth.farm.sweep", "glcloth.weave.named", "OpenEXR", "glcontext"]
# Errors that are the same ones here as in a process.
KINDS = {kind.__name__: kind for kind in (InputError, NoOpenGLError, ShaderError, DriverError, MemoryError)}


class Job(Protocol):
    """Pictures that are known by their numbers."""

    def file(self, number: int) -> Path:
        """Where a picture is written."""

    def pictures(self, numbers: Iterable[int]) -> Iterator[np.ndarray]:
        """Yield the pictures of ascending numbers."""

    def write(self, number: int, picture: np.ndarray) -> dict:
        """Write a picture, whole or not at all; what is to be told of it."""


def threads_of(workers: int) -> int:
    """Threads of Mesa's rasteriser for each of some processes: they share the cores evenly."""
    return max(1, len(os.sched_getaffinity(0)) // workers)


def share(job: Job, numbers: Iterable[int], workers: int) -> Iterator[dict]:
    """Make the pictures of some numbers by `workers` processes; yields the result of each as it is done.

    LP_NUM_THREADS is set for the processes (`threads_of`) unless the user has set it. Raises an error of KINDS as the job
    does, and RuntimeError for a picture at which three processes died.
    """
    crew = _Crew(job, list(numbers), workers)
    try:
        yield from crew.results()
    finally:
        crew.stop()


class _Crew:
    """The processes of one job, and what each has in hand."""

    def __init__(self, job: Job, numbers: list[int], workers: int):
        self.job, self.waiting = job, sorted(numbers)
        self.threads = threads_of(min(workers, len(numbers) or 1))
        self.deaths: Counter[int] = Counter()
        self.hands: dict[Connection, tuple[Any, int | None]] = {}  # pipe -> process, the number in its hands
        for _ in range(min(workers, len(numbers))):
            self.hire()

    def hire(self) -> None:
        """Start a process, and give it a picture."""
        context = multiprocessing.get_context("forkserver")
        context.set_forkserver_preload(LOADED)
        ours, theirs = context.Pipe()
        # The one that forks has the surroundings of its own start, not those of now.
        arguments = theirs, self.job, self.threads, dict(os.environ)
        process = context.Process(target=_work, args=arguments, daemon=True)
        with _deaf():
            forkserver.ensure_running()
        process.start()  # waits until that one has loaded glcloth, and Ctrl-C is heard
        theirs.close()
        self.hands[ours] = process, None
        self.give(ours)

    def give(self, pipe: Connection) -> None:
        """Hand the lowest number that waits to a process, or let it go."""
        process, _ = self.hands[pipe]
        number = heapq.heappop(self.waiting) if self.waiting else None
        self.hands[pipe] = process, number
        with contextlib.suppress(OSError):  # a process that is dead is found out by its pipe
            pipe.send(number)

    def results(self) -> Iterator[dict]:
        """Yield results until all is done."""
        while any(number is not None for _, number in self.hands.values()):
            for pipe in wait(list(self.hands)):
                assert isinstance(pipe, Connection)
                try:
                    kind, value = pipe.recv()
                except (EOFError, OSError):
                    self.bury(pipe)
                    continue
                if kind == "said":
                    warn(value)
                elif kind == "done":
                    self.give(pipe)
                    yield value
                else:
                    raise KINDS.get(kind, RuntimeError)(value)

    def bury(self, pipe: Connection) -> None:
        """A process has died: its number waits again, and another process takes its place."""
        process, number = self.hands.pop(pipe)
        process.join()
        pipe.close()
        if number is None:
            return
        self.clean(number)
        self.deaths[number] += 1
        if self.deaths[number] == DEATHS:
            raise RuntimeError(
                f"{self.job.file(number)}: {DEATHS} processes died at it, the last by {process.exitcode}"
            )
        warn(f"a process died ({process.exitcode}) at {self.job.file(number)}; another makes it")
        heapq.heappush(self.waiting, number)
        self.hire()

    def clean(self, number: int) -> None:
        """Delete what a process that was stopped had half written."""
        file = self.job.file(number)
        for rest in file.parent.glob(f".{file.stem}.*{file.suffix}"):
            rest.unlink(missing_ok=True)

    def stop(self) -> None:
        """End what still runs."""
        for pipe, (process, number) in self.hands.items():
            if number is not None:
                process.kill()
            pipe.close()
            process.join()
            if number is not None:
                self.clean(number)
        self.hands = {}


@contextlib.contextmanager
def _deaf() -> Iterator[None]:
    """What is started meanwhile does not hear Ctrl-C, which whoever starts it hears."""
    deaf = threading.current_thread() is threading.main_thread()
    before = signal.signal(signal.SIGINT, signal.SIG_IGN) if deaf else None
    try:
        yield
    finally:
        if deaf:
            signal.signal(signal.SIGINT, before)


# -- in the process --------------------------------------------------------------------------------------------------


class _Told(io.TextIOBase):
    """The stderr of a process: its warnings go to whoever started it, who says each once."""

    def __init__(self, pipe: Connection):
        self.pipe, self.line = pipe, ""

    def write(self, text: str) -> int:
        """Take text; whole lines that are warnings are sent."""
        *lines, self.line = (self.line + text).split("\n")
        for line in lines:
            if line.startswith(WARNING):
                self.pipe.send(("said", line.removeprefix(WARNING)))
        return len(text)


def _work(pipe: Connection, job: Job, threads: int, environment: Mapping[str, str]) -> None:
    """Make pictures until no number comes, on so many threads of Mesa's and of the algebra's."""
    sys.stderr = _Told(pipe)
    for name in os.environ.keys() - environment.keys():
        del os.environ[name]
    os.environ.update(environment)
    os.environ.setdefault("LP_NUM_THREADS", str(threads))
    feed = _Feed(pipe)
    try:
        with threadpool_limits(threads, user_api="blas"):
            while feed.more():
                for picture in job.pictures(feed.ascending()):
                    pipe.send(("done", job.write(feed.number, picture)))
    except EOFError:
        pass
    except tuple(KINDS.values()) as error:
        kind = next(name for name, one in KINDS.items() if isinstance(error, one))
        pipe.send((kind, str(error)))
    except Exception:
        pipe.send(("fault", traceback.format_exc()))


class _Feed:
    """The numbers that come through a pipe, in ascending runs."""

    def __init__(self, pipe: Connection):
        self.pipe, self.number, self.next = pipe, -1, None

    def more(self) -> bool:
        """Whether another number has come."""
        if self.next is None:
            self.next = self.pipe.recv()
        return self.next is not None

    def ascending(self) -> Iterator[int]:
        """Numbers as long as they ascend; one that does not begins the next run."""
        self.number = -1
        while self.more() and self.next > self.number:
            self.number, self.next = self.next, None
            yield self.number
