"""Drafts of other programs, as the text of a WIF file: Fiberworks (.dtx), WeavePoint (.wpo), TempoWeave (.twa)."""

from __future__ import annotations

import io
import warnings
import zipfile
import zlib

from ..errors import InputError

PROGRAMS = {".dtx": "Fiberworks", ".wpo": "WeavePoint", ".twa": "TempoWeave"}
SUFFIXES = (".wif", *PROGRAMS)
MAIN = "twamain.waf"  # the WIF in TempoWeave's archive


def is_draft(name: str) -> bool:
    """Whether a name ends as a draft's file does."""
    return name.lower().endswith(SUFFIXES)


def wif_bytes(data: bytes, suffix: str, most: int) -> bytes:
    """The WIF file that says what `data`, the bytes of a file with this suffix, says.

    .dtx and .wpo are read by dtx-to-wif (MIT), which the extra `drafts` installs. most : bytes that a WIF may have.
    Raises InputError (without the file's name) for a damaged file, and where the library is missing.
    """
    program = PROGRAMS[suffix]
    if suffix == ".twa":
        try:
            with zipfile.ZipFile(io.BytesIO(data)) as archive, archive.open(MAIN) as file:
                return file.read(most + 1)
        except (
            zipfile.BadZipFile,
            KeyError,
            EOFError,
            RuntimeError,
            NotImplementedError,
            ValueError,
            zlib.error,
            OSError,
        ):
            raise InputError(f"is no archive with {MAIN}, as {program} writes it; export the draft as WIF") from None
    try:
        from dtx_to_wif.dtx_reader import read_dtx
        from dtx_to_wif.wif_writer import write_wif
        from dtx_to_wif.wpo_reader import read_wpo
    except ImportError:
        hint = "pip install glcloth[drafts], or export the draft as WIF"
        raise InputError(f"a draft of {program}, which the library dtx-to-wif reads; {hint}") from None
    out = io.StringIO()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            if suffix == ".wpo":
                pattern = read_wpo(io.BytesIO(data), "draft")
            else:
                pattern = read_dtx(io.StringIO(data.decode("cp1252", "replace")), "draft")
            write_wif(out, pattern)
    except Exception as error:  # the library has no errors of its own: it lets out whatever its parsing meets
        reason = " ".join(str(error).split())[:80] or type(error).__name__
        raise InputError(f"cannot be read as a draft of {program} ({reason}); export it as WIF") from None
    return out.getvalue().encode()
