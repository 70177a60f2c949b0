"""Where the package's data lives, where the cache is, and how files are written: whole or not at all."""

from __future__ import annotations

import os
import re
import shlex
import stat
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import platformdirs

from .errors import InputError

PACKAGE = Path(__file__).resolve().parent
# A wheel carries the shaders in glcloth/_data; in a checkout they stand beside the package.
DATA = PACKAGE / "_data" if (PACKAGE / "_data").is_dir() else PACKAGE.parent
GLSL = DATA / "glsl"


def cache_dir() -> Path:
    """Return the folder for tables made on this machine (`GLCLOTH_CACHE` overrides it); it may not exist yet."""
    return Path(os.environ.get("GLCLOTH_CACHE") or platformdirs.user_cache_dir("glcloth", appauthor=False))


def path_of(name: str | Path) -> Path:
    """The path that a name of the user means. Raises InputError for one that no file can have."""
    path = Path(name)
    try:
        encoded = os.fsencode(path)
    except UnicodeEncodeError:
        encoded = b"\0"
    if b"\0" in encoded or len(encoded) > 4095 or any(len(part) > 255 for part in encoded.split(b"/")):
        raise InputError(f"{name}: no file can have such a name; expected a file or a built-in name")
    return path


def typed_path(text: str) -> Path:
    """The path that someone types, where ~ is a user's folder. Raises InputError."""
    try:
        return path_of(text).expanduser()
    except RuntimeError:
        raise InputError(f"{text}: there is no such user's folder; give the whole path") from None


def is_file(name: str | Path) -> bool:
    """Whether there is a file of that name; False also for a name that no file can have."""
    try:
        return Path(name).is_file()
    except OSError:
        return False


def check_writable(path: str | Path) -> Path:
    """Return `path` if a file can be made there, so that a long job fails before it starts.

    Raises InputError when the folder is missing or not writable, or when `path` is a folder, a pipe or a device.
    """
    path = path_of(path)
    if os.path.islink(os.path.realpath(path)):
        raise InputError(f"{path}: is a symbolic link to itself; choose another output path")
    if path.is_dir():
        raise InputError(f"{path}: is a folder, expected a file name; give a name such as {path / 'picture.png'}")
    if not path.parent.is_dir():
        raise InputError(
            f"{path}: folder {path.parent} does not exist; make it first: mkdir -p {shlex.quote(str(path.parent))}"
        )
    if path.exists() and not path.is_file():
        raise InputError(f"{path}: is a pipe or a device, expected a file name; choose another output path")
    if path.exists() and not os.access(path, os.W_OK):
        raise InputError(f"{path}: cannot be written, permission denied; choose another output path")
    try:
        # Asking for permission is not enough: some folders say yes and then refuse.
        _temporary(path).unlink()
    except OSError as error:
        raise InputError(f"{path}: no file can be made there ({error.strerror}); choose another output path") from None
    return path


@contextmanager
def atomic_write(path: str | Path) -> Iterator[Path]:
    """Yield a temporary path beside `path`; rename it to `path` on success, delete it on any error or Ctrl-C.

    A file that is written over keeps its permissions and its owner; a symbolic link stays, and its target is written.
    The temporary name keeps the suffix, because image and mesh libraries choose the format by it.
    """
    given, path = path, Path(os.path.realpath(path_of(path)))
    try:
        check_writable(path)
        temporary = _temporary(path)
    except OSError as error:
        raise InputError(f"{given}: cannot be written ({error.strerror}); choose another output path") from None
    try:
        yield temporary
        _take_after(temporary, path)
        os.replace(temporary, path)
    except OSError as error:
        raise InputError(
            f"{given}: cannot be written ({error.strerror or error}); choose another output path"
        ) from None
    finally:
        temporary.unlink(missing_ok=True)


MARK = ".glcloth-"  # in the names of temporary files
STALE = 3600.0  # seconds after which a temporary file that nobody has written to belongs to a run that was killed
_swept: set[Path] = set()


def _temporary(path: Path) -> Path:
    """A new empty file beside `path`; what killed runs of this user left there goes first."""
    if path.parent not in _swept:
        _swept.add(path.parent)
        _sweep(path.parent)
    handle, name = tempfile.mkstemp(prefix=f".{path.stem[:40]}{MARK}", suffix=path.suffix, dir=path.parent)
    os.close(handle)
    return Path(name)


def _sweep(folder: Path) -> None:
    """Delete our temporary files in a folder that are an hour old."""
    with suppress(OSError), os.scandir(folder) as entries:
        for entry in entries:
            if entry.name.startswith(".") and MARK in entry.name and entry.is_file(follow_symlinks=False):
                found = entry.stat(follow_symlinks=False)
                if found.st_uid == os.geteuid() and time.time() - found.st_mtime > STALE:
                    with suppress(OSError):
                        os.unlink(entry.path)


def _take_after(temporary: Path, path: Path) -> None:
    """Give a new file the permissions and the owner of the one that it replaces, or a user's ordinary permissions."""
    if path.exists():
        old = path.stat()
        if (old.st_uid, old.st_gid) != (os.geteuid(), os.getegid()):
            with suppress(OSError):
                os.chown(temporary, old.st_uid, old.st_gid)
        temporary.chmod(stat.S_IMODE(old.st_mode) & 0o777)
        return
    # mkstemp makes private files.
    mask = os.umask(0)
    os.umask(mask)
    temporary.chmod(0o666 & ~mask)


# -- text ----------------------------------------------------------------------------------------------------------------

MOST_TEXT = 4 << 20  # bytes of a TOML or JSON file
DEEPEST = 16  # tables and lists within each other, and parts of a dotted key
# Possessive, and from the beginning of a word on, so that it takes no longer than the text is long.
_KEY = r"""(?:[\w-]++|"[^"\n]*+"|'[^'\n]*+')[ \t]*+\.[ \t]*+"""
_TOO_DEEP = re.compile(rf"(?:\[\s*+){{{DEEPEST}}}|(?<![\w-])(?:{_KEY}){{{DEEPEST}}}")


def read_text(path: str | Path, expected: str) -> str:
    """The text of a file of at most MOST_TEXT bytes; `expected` names in errors what it should be. Raises InputError."""
    path = Path(path)
    try:
        if path.exists() and not path.is_file():
            raise InputError(f"{path}: is a folder, a pipe or a device; expected {expected}")
        with open(path, "rb") as file:
            data = file.read(MOST_TEXT + 1)
        if len(data) > MOST_TEXT:
            raise InputError(f"{path}: is larger than {MOST_TEXT / 1e6:.0f} MB, more than is read; expected {expected}")
        return data.decode("utf-8")
    except InputError:
        raise
    except FileNotFoundError:
        raise InputError(f"{path}: no such file; expected {expected}") from None
    except OSError as error:
        raise InputError(f"{path}: cannot be read as a text file ({error.strerror}); expected {expected}") from None
    except ValueError as error:  # no UTF-8, or a name that no file can have
        raise InputError(f"{path}: cannot be read as a text file ({error}); expected {expected}") from None


def read_bytes(path: str | Path, most: int) -> bytes:
    """The content of an ordinary file of at most `most` bytes; pipes and devices, which may never end, are refused.

    Raises InputError.
    """
    path = Path(path)
    if path.exists() and not path.is_file():
        kind = "a folder" if path.is_dir() else "no ordinary file"
        raise InputError(f"{path}: is {kind}, expected a file; give another path")
    try:
        size = path.stat().st_size
        if size > most:
            raise InputError(f"{path}: {size:,} bytes, at most {most:,} can be read; reduce it")
        with open(path, "rb") as file:
            return file.read(size)
    except FileNotFoundError:
        raise InputError(f"{path}: no such file; check the path") from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise InputError(f"{path}: cannot be read ({reason}); check its permissions") from None


def beside(path: Path, name: str) -> Path | None:
    """The file of a name, which another file gives, in that file's folder or below it; None where there is none.

    Names may have been written on Windows: `\\` separates folders, capitals do not count if nothing else fits.
    """
    folder = path.parent.resolve()
    try:
        wanted = (folder / name.strip().replace("\\", "/")).resolve()
        if wanted == folder or not wanted.is_relative_to(folder):
            return None
        if wanted.is_file():
            return wanted
        if wanted.parent.is_dir() and wanted.name:
            fits = (file for file in sorted(wanted.parent.iterdir()) if file.name.lower() == wanted.name.lower())
            return next((file for file in fits if file.is_file()), None)
    except (OSError, ValueError, RuntimeError):  # a name that no file can have, a ring of links
        pass
    return None


def read_toml(path: str | Path, expected: str) -> dict:
    """The content of a TOML file; `expected` names in errors what it should be. Raises InputError."""
    import tomllib

    text = read_text(path, expected)
    if _TOO_DEEP.search(text):  # a dotted key takes memory as the square of its parts
        raise InputError(f"{path}: more than {DEEPEST} tables or lists within each other; expected {expected}")
    try:
        return tomllib.loads(text)
    except RecursionError:
        raise InputError(f"{path}: tables or lists are too deep within each other; expected {expected}") from None
    except ValueError as error:  # also a whole number of thousands of digits
        raise InputError(f"{path}: not TOML: {error}") from None


def read_json(text: str, where: str, expected: str) -> Any:
    """The value of a JSON text that a file holds. Raises InputError."""
    import json

    try:
        return json.loads(text)
    except RecursionError:
        raise InputError(f"{where}: lists are too deep within each other; expected {expected}") from None
    except (TypeError, ValueError) as error:  # also a whole number of thousands of digits
        raise InputError(f"{where}: not valid JSON: {error}; expected {expected}") from None
