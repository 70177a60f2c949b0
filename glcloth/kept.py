"""Arrays that take long to make, kept in the cache folder under a key of all that they depend on. Nothing there is needed: a file
that is missing, damaged or cannot be written is as none."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

import numpy as np

from .errors import InputError
from .files import atomic_write, cache_dir

MOST_BYTES = 1 << 29  # of a folder whose files are counted


def kept_path(folder: str, *parts: object) -> Path:
    """The file, in a folder of the cache, of an array that depends on these parts: arrays by their bytes, all else by `repr`."""
    key = hashlib.blake2b(digest_size=16)
    for part in parts:
        if isinstance(part, np.ndarray):
            key.update(repr((part.shape, part.dtype.str)).encode())
            key.update(np.ascontiguousarray(part).tobytes())
        else:
            key.update(repr(part).encode())
    return cache_dir() / folder / f"{key.hexdigest()}.npz"


def read_kept(path: Path, shape: tuple[int, ...], largest: float) -> np.ndarray | None:
    """The float32 array of a file; None where there is none of this shape, or values are not finite or above `largest`."""
    try:
        with np.load(path) as file:  # a zip archive, with a sum over its bytes
            array = file["array"]
    except Exception:  # whatever a damaged file makes NumPy and zipfile raise
        return None
    good = array.shape == shape and array.dtype == np.float32 and np.isfinite(array).all()
    return array if good and np.abs(array).max(initial=0.0) <= largest else None


def read_kept_words(path: Path, shapes: Sequence[tuple[int, ...]]) -> list[np.ndarray] | None:
    """As `read_kept`, several arrays of uint32, whose values may be any."""
    try:
        with np.load(path) as file:
            arrays = [file[f"array_{i}"] for i in range(len(shapes))]
    except Exception:  # whatever a damaged file makes NumPy and zipfile raise
        return None
    good = all(a.shape == shape and a.dtype == np.uint32 for a, shape in zip(arrays, shapes, strict=True))
    return arrays if good else None


def keep_words(path: Path, arrays: Sequence[np.ndarray], most: int | None = None) -> None:
    """As `keep`, several arrays of uint32."""
    _write(path, {f"array_{i}": array for i, array in enumerate(arrays)}, most)


def keep(path: Path, array: np.ndarray, most: int | None = None) -> None:
    """Write an array, where one can be written, of MOST_BYTES / 2 at most; of more than `most` files beside it, or MOST_BYTES in
    all, the oldest go."""
    _write(path, {"array": array}, most)


def _write(path: Path, arrays: dict[str, np.ndarray], most: int | None) -> None:
    if sum(array.nbytes for array in arrays.values()) > MOST_BYTES // 2:
        return
    with suppress(InputError, OSError):
        path.parent.mkdir(parents=True, exist_ok=True)
        with atomic_write(path) as temporary, open(temporary, "wb") as file:
            np.savez(file, **arrays)  # type: ignore[arg-type]
        if most is not None:
            files = [(one, one.stat()) for one in path.parent.glob("[!.]*.npz")]  # not those that others are writing
            left, room = most, MOST_BYTES
            for one, stat in sorted(files, key=lambda file: file[1].st_mtime, reverse=True):
                left, room = left - 1, room - stat.st_size
                if left < 0 or room < 0:
                    one.unlink()
