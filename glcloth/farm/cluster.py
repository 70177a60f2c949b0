"""The same jobs on a Dask cluster: each number is a task; whoever is free takes the next, and one that is lost is made again.

A worker returns its picture and the client writes it, so that only what a scene reads has to be on the workers' disks.
"""

from __future__ import annotations

import threading
import uuid
from collections.abc import Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np

from ..errors import InputError
from .pool import Job

_gl = ThreadPoolExecutor(1, "glcloth")  # OpenGL's context belongs to one thread, whichever asks
_lock = threading.Lock()
_line: tuple[Job, _Line] | None = None


def share(job: Job, numbers: Iterable[int], address: str) -> Iterator[dict]:
    """Make the pictures of some numbers by the workers of a scheduler; yields the result of each as it is done.

    Raises InputError where the extra is missing or the scheduler does not answer, and as the job does.
    """
    try:
        from distributed import Client, as_completed
    except ImportError:
        raise InputError("--cluster: needs Dask: pip install 'glcloth[cluster]'") from None
    try:
        client = Client(address, timeout=10)
    except (OSError, TimeoutError, ValueError) as error:
        raise InputError(
            f"--cluster {address}: no scheduler answers ({type(error).__name__}); start one: dask scheduler"
        ) from None
    name = uuid.uuid4().hex  # other clients of the scheduler have jobs too
    with client:
        tasks = [
            client.submit(make, job, n, key=("glcloth", name, n), priority=-n, pure=False, retries=3) for n in numbers
        ]
        for task in as_completed(tasks):
            number, picture = task.result()
            task.release()
            yield job.write(number, picture)


def make(job: Job, number: int) -> tuple[int, np.ndarray]:
    """The picture of a number, on a worker."""
    return number, _gl.submit(_picture, job, number).result()


def _picture(job: Job, number: int) -> np.ndarray:
    global _line
    with _lock:
        if _line is not None and (_line[0] != job or number <= _line[1].number):
            _line[1].close()
            _line = None
        if _line is None:
            _line = job, _Line(job)
        try:
            return _line[1].picture(number)
        except BaseException:
            _line = None  # pictures that have failed do not go on
            raise


class _Line:
    """The pictures of a job in ascending order, one at a time."""

    def __init__(self, job: Job):
        self.number = -1
        self._pictures: Any = job.pictures(self._numbers())

    def _numbers(self) -> Iterator[int]:
        while True:
            yield self.number

    def picture(self, number: int) -> np.ndarray:
        """The next picture."""
        self.number = number
        return next(self._pictures)

    def close(self) -> None:
        """Free the context."""
        self._pictures.close()
