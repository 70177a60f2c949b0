"""What the readers of pictures share: limits, errors, and silence of the libraries."""

from __future__ import annotations

import contextlib
import io
import os
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from ..errors import InputError

MOST_PIXELS = 1 << 27  # 16384 x 8192
UNASKED_PIXELS = 1 << 24  # up to so many whatever the file's size; beyond, a file of no content is no picture
PIXELS_PER_BYTE = 64


class TooLargeError(InputError):
    """More pixels than can be read."""


def check_pixels(what: str | Path, width: int, height: int, file_bytes: int, planes: int = 1) -> None:
    """Raise InputError for more pixels (times `planes`) than can be read, before any of them is.

    What decodes to gigabytes from a small file is refused sooner.
    """
    pixels = max(width, 0) * max(height, 0)
    if pixels > MOST_PIXELS:
        raise TooLargeError(f"{what}: {width} x {height} pixels, at most {MOST_PIXELS:,} can be read; make it smaller")
    if pixels * planes > UNASKED_PIXELS and pixels * planes > PIXELS_PER_BYTE * file_bytes:
        raise TooLargeError(
            f"{what}: {width} x {height} pixels in a file of {file_bytes:,} bytes, at most "
            f"{max(UNASKED_PIXELS, PIXELS_PER_BYTE * file_bytes):,} can be read; make it smaller"
        )


def broken(path: str | Path, reason: str = "damaged or cut short") -> InputError:
    """The error for a picture that cannot be decoded."""
    return InputError(f"{path}: cannot be decoded, {reason}; copy or save it again")


@contextlib.contextmanager
def silence() -> Iterator[None]:
    """Send output of C++ libraries to a scratch file: a user sees our one line and no other."""
    try:
        sys.stdout.flush()
        sys.stderr.flush()
    except (AttributeError, ValueError, OSError):
        pass
    with tempfile.TemporaryFile() as scratch, contextlib.ExitStack() as stack:
        for descriptor in (1, 2):
            try:
                saved = os.dup(descriptor)
            except OSError:
                continue
            stack.callback(os.close, saved)
            stack.callback(os.dup2, saved, descriptor)
            os.dup2(scratch.fileno(), descriptor)
        with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
            yield


def decoded(file: str | Path, named: str | Path, unassociated: bool = False) -> np.ndarray:
    """The pixels [H, W, C] of a picture as float32, by OpenImageIO; whole numbers as 0 to 1. `unassociated`: colours that
    are not multiplied by alpha stay so. Raises InputError, which calls the file `named`."""
    import OpenImageIO

    config = OpenImageIO.ImageSpec()
    if unassociated:
        config["oiio:UnassociatedAlpha"] = 1
    with silence():
        picture = OpenImageIO.ImageInput.open(str(file), config)
        pixels = picture.read_image("float") if picture else None
        # Unread messages would be printed by the library when it is unloaded.
        OpenImageIO.geterror()
        if picture:
            picture.geterror()
            picture.close()
    if pixels is None or np.ndim(pixels) != 3:
        raise broken(named)
    return pixels
