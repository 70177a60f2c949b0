"""Frames by one process and by several: the same bits, with one process killed in the middle, and the times.

python tests/measure/workers.py [--frames 60] [--workers 2] [--size 240x180] [--fabric linen] [--rounds 1] [--cluster]

One process has all cores (LP_NUM_THREADS as it comes); the workers share them. In the first round a worker is killed by
SIGKILL when half the frames are there. --cluster also does it by a Dask scheduler and workers of their own, of which the
last joins late and one is killed. Printed: seconds of wall and of CPU of each, and whether frames are equal to the bit.
"""

import ctypes
import os
import resource
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import common
import numpy as np

from glcloth.image import read_image

PR_SET_CHILD_SUBREAPER = 36


def command(folder, options, *more):
    words = ["animate", "-o", folder / "%04d.exr", "--frames", options.frames, "--size", options.size]
    return [sys.executable, "-m", "glcloth", *map(str, [*words, "--fabric", options.fabric, *more])]


def below(parent):
    """The fork servers that a process started, or the workers that a fork server forked."""
    found = subprocess.run(["pgrep", "-P", str(parent), "-f", "forkserver"], capture_output=True, text=True).stdout
    return [int(p) for p in found.split()]


def children(pid):
    """The workers of a command."""
    return [worker for server in below(pid) for worker in below(server)]


def timed(words, folder, half=None, victims=None):
    """(wall, CPU) seconds of a command; when `half` frames are there, a process of `victims` is killed."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    begin = time.perf_counter()
    ctypes.CDLL(None).prctl(PR_SET_CHILD_SUBREAPER, 1)  # the fork server outlives its command, and is ours then
    process = subprocess.Popen(words)
    while process.poll() is None:
        if half is not None and len(list(folder.glob("*.exr"))) >= half:
            os.kill(victims(process.pid)[0], signal.SIGKILL)
            half = None
        time.sleep(0.05)
    for server in below(os.getpid()):
        os.waitpid(server, 0)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    if process.returncode:
        sys.exit(f"{words[3]}: exit {process.returncode}")
    cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return time.perf_counter() - begin, cpu


def equal(a, b, count):
    return all(np.array_equal(read_image(a / f"{n:04d}.exr"), read_image(b / f"{n:04d}.exr")) for n in range(count))


def cluster(home, options):
    """Dask's own scheduler and workers; the second worker joins late, the first is killed."""
    scheduler = subprocess.Popen(
        [sys.executable, "-m", "distributed.cli.dask_scheduler", "--port", "8799", "--no-dashboard"]
    )
    worker = [sys.executable, "-m", "distributed.cli.dask_worker", "tcp://127.0.0.1:8799", "--nthreads", "1",
              "--no-nanny", "--no-dashboard", "--local-directory", str(home)]  # fmt: skip
    os.environ["LP_NUM_THREADS"] = "1"
    workers = [subprocess.Popen(worker)]
    folder = home / "cluster"

    def victims(_):
        workers.append(subprocess.Popen(worker))
        time.sleep(8.0)
        return [workers[0].pid]

    try:
        spent = timed(
            command(folder, options, "--cluster", "tcp://127.0.0.1:8799"), folder, options.frames // 3, victims
        )
    finally:
        for process in [*workers, scheduler]:
            process.kill()
            process.wait()
        del os.environ["LP_NUM_THREADS"]
    return folder, spent


def main():
    options = common.options(__doc__, frames=60, workers=2, size="240x180", fabric="linen", rounds=1, cluster=False)
    common.head("", "wall s", "CPU s", "equal")
    with tempfile.TemporaryDirectory() as home:
        home = Path(home)
        for number in range(options.rounds):
            one, many = home / f"one{number}", home / f"many{number}"
            common.row("one process", *timed(command(one, options), one), "")
            half = options.frames // 2 if number == 0 else None
            spent = timed(command(many, options, "--workers", options.workers), many, half, children)
            said = "one killed" if half else "all alive"
            common.row(f"{options.workers} workers, {said}", *spent, equal(one, many, options.frames))
            assert not list(many.glob(".*")), "half a frame"
        if options.cluster:
            folder, spent = cluster(home, options)
            common.row("Dask, one late, one killed", *spent, equal(home / "one0", folder, options.frames))


main()
