"""Damaged files of every format by the thousand: python tests/measure/fuzz.py 20000 [--seed 1] [--formats ply,glb].

Each case is read in a process with limits: what raises anything but InputError, takes over 10 s of a CPU, more than 1.5 GB, or
prints control characters is kept in the folder --keep, and counted. A case is made from the seed and its number alone:
--only NUMBER runs one again. What a shell would do to --formats with a space in a name, quotes prevent.
"""

import common  # noqa: I001
import os
import random
import signal
import sys
import tempfile
import traceback
from collections import Counter
from multiprocessing import Process, Queue
from pathlib import Path

from mutations import FORMATS, KINDS, corpus, damaged, random_edits

from glcloth.cli import _quiet_libraries
from glcloth.errors import MAX_LINE, InputError

SECONDS, MEGABYTES = 10, 1536


class TookTooLong(BaseException):
    """Not an Exception, so that no reader swallows it."""


def peak_megabytes():
    """The most memory since the last call."""
    text = Path("/proc/self/status").read_text()
    peak = int(text.split("VmHWM:")[1].split()[0]) / 1024
    Path("/proc/self/clear_refs").write_text("5")
    return peak


def outcome(read, path, heard):
    """A word for what reading a file came to, and the detail."""
    signal.setitimer(signal.ITIMER_PROF, SECONDS)
    try:
        with _quiet_libraries():  # as the command line has it
            read(path)
        result = "read", ""
    except InputError as error:
        said = str(error)
        result = ("refused", said) if said.isprintable() and len(said) <= MAX_LINE else ("no line", said)
    except TookTooLong:
        result = "hang", "".join(traceback.format_exc().splitlines()[-3:])
    except BaseException as error:
        frame = traceback.extract_tb(error.__traceback__)[-1]
        result = "raw", f"{type(error).__name__}: {error} at {Path(frame.filename).name}:{frame.lineno}"
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
    heard.seek(0)
    printed = heard.read().decode(errors="replace")
    heard.seek(0)
    heard.truncate()
    if any(not line.isprintable() or len(line) > MAX_LINE for line in printed.split("\n")):
        return "control", printed[:200]
    if any("warning" not in line for line in printed.splitlines()):
        return "library", printed[:200]
    return result


def work(name, numbers, seed, keep, queue):
    """Try cases of one format, and tell of each."""

    def stop(*_):
        raise TookTooLong

    signal.signal(signal.SIGPROF, stop)
    heard = tempfile.TemporaryFile()
    for descriptor in (1, 2):
        os.dup2(heard.fileno(), descriptor)
    sys.stdout = sys.stderr = open(os.dup(1), "w", buffering=1)
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        sound, format = corpus(name, folder), FORMATS[name]
        for path in sound:
            format.read(folder / path.name)
        peak_megabytes()
        for number in numbers:
            rng = random.Random(f"{seed} {name} {number}")
            source = sound[rng.randrange(len(sound))]
            path = folder / source.name
            mend = format.mend if rng.random() < 0.7 else None
            kinds = ("leaf",) if format.tree and rng.random() < 0.7 else KINDS
            path.write_bytes(damaged(source.read_bytes(), random_edits(rng, kinds), mend))
            queue.put((name, number, "begun", ""))
            word, detail = outcome(format.read, path, heard)
            if peak_megabytes() > MEGABYTES:
                word, detail = "memory", f"{word} {detail}"
            if word not in ("read", "refused"):
                (keep / f"{name.replace(' ', '_')}_{number}_{word}{path.suffix}").write_bytes(path.read_bytes())
            queue.put((name, number, word, detail))
            path.write_bytes(source.read_bytes())
    queue.put((name, -1, "done", ""))


def run(name, numbers, seed, keep, counts, details):
    """Try cases of one format; a process that dies is a case too, and another goes on behind it."""
    numbers = list(numbers)
    while numbers:
        queue: Queue = Queue()
        process = Process(target=work, args=(name, numbers, seed, keep, queue))
        process.start()
        last = None
        while True:
            try:
                _, number, word, detail = queue.get(timeout=12 * SECONDS)
            except Exception:
                word, number, detail = "killed", last, f"exit code {process.exitcode}: it hung in a library, or died"
                process.kill()
            if word == "begun":
                last = number
                continue
            if word == "done":
                return
            counts[word] += 1
            numbers = [n for n in numbers if number is None or n > number]
            if word not in ("read", "refused"):
                details.append((name, number, word, detail))
                print(name, number, word, "".join(c if c.isprintable() else "?" for c in detail)[:200], flush=True)
            if word == "killed":
                if number is None:
                    return
                break


def main():
    """Print what each format came to."""
    args = common.options(
        __doc__, [], seed=1, formats=list(FORMATS), only=-1, keep=Path(tempfile.gettempdir()) / "fuzz"
    )
    args.keep.mkdir(parents=True, exist_ok=True)
    os.environ["GLCLOTH_CACHE"] = tempfile.mkdtemp()
    total = int(args.environments[0]) if args.environments else 20_000
    words = ("read", "refused", "raw", "hang", "memory", "control", "library", "no line", "killed")
    common.row("format", *words)
    common.row(*["---"] * (1 + len(words)))
    sum_, details = Counter(), []
    for name in args.formats:
        counts = Counter()
        numbers = [args.only] if args.only >= 0 else range(total // len(args.formats))
        run(name, numbers, args.seed, args.keep, counts, details)
        common.row(name, *(counts[word] for word in words))
        sum_ += counts
    common.row("all", *(sum_[word] for word in words))


if __name__ == "__main__":
    main()
