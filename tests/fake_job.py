"""A job of numbers in files, for the processes of glcloth/farm; in a file of its own, so that they start quickly."""

import os
import signal
from pathlib import Path

import numpy as np


class Wrong:
    """A job that raises an error as soon as it begins."""

    def __init__(self, error):
        self.error = error

    def file(self, number):
        return Path(f"{number}.txt")

    def pictures(self, numbers):
        raise self.error

    def write(self, number, picture):
        return {"number": number}


class Surroundings(Wrong):
    """What a process has around it."""

    def __init__(self):
        super().__init__(None)

    def pictures(self, numbers):
        for _ in numbers:
            yield None

    def write(self, number, picture):
        deaf = signal.getsignal(signal.SIGINT) == signal.SIG_IGN
        return {"cache": os.environ.get("GLCLOTH_CACHE"), "deaf": deaf}


class Fake:
    """A job of numbers in files; its first process dies at some of them, with half a picture on the disk."""

    def __init__(self, folder, deadly=(), always=False):
        self.folder, self.deadly, self.always = folder, deadly, always

    def __eq__(self, other):
        return isinstance(other, Fake) and self.folder == other.folder

    def file(self, number):
        return Path(self.folder) / f"{number}.txt"

    def pictures(self, numbers):
        for number in numbers:
            mark = Path(self.folder) / f"died_at_{number}"
            if number in self.deadly and (self.always or not mark.exists()):
                mark.touch()
                (Path(self.folder) / f".{number}.half.txt").touch()
                os.kill(os.getpid(), signal.SIGKILL)
            yield np.full(3, number)

    def write(self, number, picture):
        self.file(number).write_text(f"{picture.sum()} {os.environ.get('LP_NUM_THREADS')}")
        return {"number": number}
