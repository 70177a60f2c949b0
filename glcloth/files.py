"""Where the package's data lives, where the cache is, and how files are written: whole or not at all."""

from __future__ import annotations

import os
import shlex
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import platformdirs

from .errors import InputError

PACKAGE = Path(__file__).resolve().parent
# A wheel carries the shaders in glcloth/_data; in a checkout they stand beside the package.
DATA = PACKAGE / "_data" if (PACKAGE / "_data").is_dir() else PACKAGE.parent
GLSL = DATA / "glsl"


def cache_dir() -> Path:
    """Return the folder for tables made on this machine (`GLCLOTH_CACHE` overrides it); it may not exist yet."""
    return Path(os.environ.get("GLCLOTH_CACHE") or platformdirs.user_cache_dir("glcloth", appauthor=False))


def check_writable(path: str | Path) -> Path:
    """Return `path` if a file can be made there, so that a long job fails before it starts.

    Raises InputError when the folder is missing or not writable, or when `path` is a folder.
    """
    path = Path(path)
    if path.is_dir():
        raise InputError(f"{path}: is a folder, expected a file name; give a name such as {path / 'picture.png'}")
    if not path.parent.is_dir():
        raise InputError(
            f"{path}: folder {path.parent} does not exist; make it first: mkdir -p {shlex.quote(str(path.parent))}"
        )
    if path.exists() and not os.access(path, os.W_OK):
        raise InputError(f"{path}: cannot be written, permission denied; choose another output path")
    try:
        # Asking for permission is not enough: some folders say yes and then refuse.
        handle, name = tempfile.mkstemp(prefix=f".{path.stem}.", dir=path.parent)
    except OSError as error:
        raise InputError(f"{path}: no file can be made there ({error.strerror}); choose another output path") from None
    os.close(handle)
    os.unlink(name)
    return path


@contextmanager
def atomic_write(path: str | Path) -> Iterator[Path]:
    """Yield a temporary path beside `path`; rename it to `path` on success, delete it on any error or Ctrl-C.

    The temporary name keeps the suffix, because image and mesh libraries choose the format by it.
    """
    path = check_writable(path)
    handle, name = tempfile.mkstemp(prefix=f".{path.stem}.", suffix=path.suffix, dir=path.parent)
    os.close(handle)
    temporary = Path(name)
    try:
        yield temporary
        # mkstemp makes private files; the result should have the user's ordinary permissions.
        mask = os.umask(0)
        os.umask(mask)
        temporary.chmod(0o666 & ~mask)
        os.replace(temporary, path)
    except OSError as error:
        raise InputError(f"{path}: cannot be written ({error.strerror or error}); choose another output path") from None
    finally:
        temporary.unlink(missing_ok=True)


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
            return file.read(most + 1)
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

    try:
        return tomllib.loads(Path(path).read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise InputError(f"{path}: no such file; expected {expected}") from None
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"{path}: cannot be read as a text file ({error}); expected {expected}") from None
    except tomllib.TOMLDecodeError as error:
        raise InputError(f"{path}: not TOML: {error}") from None
