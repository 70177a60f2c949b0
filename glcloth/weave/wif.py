"""WIF files: weavers' drafts as their programs exchange them, read into a Draft and written from one.

The rules are those of the WIF 1.1 text (1997) as its readers live it; where it and the files disagree, a comment says
which side is taken. Why not dtx-to-wif 4.7.1 (PyPI), which reads WIF too: it refuses comments behind numbers, colours
beyond Range, a Range of one number, tables with a missing index and colour sections without a table; `%` in a note stops
it; it raises RuntimeError or ValueError of several lines; and it bounds no size. All of these occur in public files.
"""

from __future__ import annotations

import contextlib
import re
from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple, NoReturn

import numpy as np

from ..color import srgb_decode, srgb_encode
from ..errors import InputError, one_line
from ..files import atomic_write, path_of
from .draft import MAX_THREADS, USUAL_CM, Draft, check_size
from .others import PROGRAMS, wif_bytes

MAX_BYTES = 4 << 20  # the largest public draft, 641 x 641, has 0.04 MB
MAX_SHAFTS = 1024  # distinct shafts, and treadles, of a draft
UNITS = {"centimeters": 1.0, "centimetres": 1.0, "cm": 1.0, "inches": 2.54, "inch": 2.54, "in": 2.54}
# A decipoint is a tenth of a printer's point, 1/720 inch.
UNITS |= {"decipoints": 2.54 / 720.0, "millimeters": 0.1, "millimetres": 0.1, "mm": 0.1}
WORDS = dict.fromkeys(("true", "on", "yes", "1"), True) | dict.fromkeys(("false", "off", "no", "0"), False)
DEFAULT_COLOR = 0.8  # display value of a thread whose colour is in no table
USUAL_SPACING = (0.003, 0.6)  # cm; sewing silk to rope


class _Entry(NamedTuple):
    """What stands behind a key, and on which line."""

    text: str
    line: int


_Section = dict[str, _Entry]


def load_draft(path: str | Path) -> Draft:
    """Read a WIF file, or a draft of Fiberworks (.dtx), WeavePoint (.wpo) or TempoWeave (.twa).

    Every file that the format allows gives a Draft; what is odd about it (threads without threading, colours beyond
    their range, spacings that no cloth has) stands in its `warnings`. Colours are decoded from display sRGB to linear
    Rec. 709; lengths are in cm. A file may say its sheds by tie-up and treadling or by a lift plan; the first is
    preferred where both exist. Raises InputError of one line for anything else: no [WIF], no threading, no sheds, a
    shaft above Shafts, text where a number belongs, more than 4 MB, 16384 threads a side or a repeat of 2^20 crossings.
    """
    path = path_of(path)
    if path.exists() and not path.is_file():
        raise InputError(one_line(f"{_short(path)}: is a folder, a pipe or a device; expected a draft (.wif)"))
    try:
        with path.open("rb") as file:
            data = file.read(MAX_BYTES + 1)
    except FileNotFoundError:
        raise InputError(one_line(f"{_short(path)}: no such file; expected a draft (.wif)")) from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise InputError(one_line(f"{_short(path)}: cannot be read ({reason}); expected a draft (.wif)")) from None
    try:
        if len(data) > MAX_BYTES:
            raise InputError(f"larger than {MAX_BYTES >> 20} MB, expected a draft; cut it to one repeat")
        if path.suffix.lower() in PROGRAMS:
            data = wif_bytes(data, path.suffix.lower(), MAX_BYTES)
            if len(data) > MAX_BYTES:
                raise InputError(f"larger than {MAX_BYTES >> 20} MB as WIF, expected a draft; cut it to one repeat")
        return parse_draft(_decoded(data), path.stem)
    except InputError as error:
        raise InputError(one_line(f"{_short(path)}: {error}")) from None


def parse_draft(text: str, title: str = "draft") -> Draft:
    """The Draft of a WIF file's text; `title` where it names none. Raises InputError (without the file's name)."""
    return _Wif(_sections(text)).draft(title)


def _short(path: Path) -> str:
    """A path whose end survives in an error of 300 characters."""
    text = str(path)
    return text if len(text) <= 100 else f"...{text[-97:]}"


def _decoded(data: bytes) -> str:
    if b"\0" in data[:4096]:
        raise InputError("is no text, expected a draft (.wif); export it as WIF 1.1")
    with contextlib.suppress(UnicodeDecodeError):
        return data.decode("utf-8-sig")
    # Old programs write Windows' code page; five of its bytes mean nothing.
    return data.decode("cp1252", "replace")


def _sections(text: str) -> dict[str, _Section]:
    """{SECTION: {key: entry}}: names in capitals, keys in small letters, the last of two equal keys."""
    sections: dict[str, _Section] = {}
    section: _Section = {}
    for number, line in enumerate(re.split(r"\r\n|\r|\n", text), 1):
        line = line.strip()
        if header := re.match(r"\[([^\]]*)\]", line):
            section = sections.setdefault(" ".join(header[1].upper().split()), {})
        elif "=" in line and not line.startswith(";"):
            key, value = line.split("=", 1)
            section[" ".join(key.lower().split())] = _Entry(value.strip(), number)
    return sections


def _fail(section: str, key, entry: _Entry, expected: str) -> NoReturn:
    value = entry.text if len(entry.text) <= 40 else f"{entry.text[:37]}..."
    raise InputError(f'line {entry.line}: [{section}] {key} = "{value}", expected {expected}; correct the line')


class _Wif:
    """The sections of one file, and what they mean."""

    def __init__(self, sections: dict[str, _Section]):
        self.sections = sections
        self.warnings: list[str] = []
        if "WIF" not in sections:
            raise InputError("has no [WIF] section, expected a draft in WIF 1.1; export it as WIF")

    def draft(self, title: str) -> Draft:
        threading = self.lists("THREADING")
        if not any(threading.values()):
            raise InputError("has no [THREADING] that names a shaft, expected one for each end; export the whole draft")
        threads = {system: self.integer(system, "threads") for system in ("WARP", "WEFT")}
        sheds, treadled = self.sheds()
        # Programs write their loom's width as Threads (1200 for a draft of 4), so what is threaded and treadled counts.
        ends = self.counted("WARP", threads["WARP"], max(k for k, v in threading.items() if v), "threading")
        picks = self.counted("WEFT", threads["WEFT"], treadled, "treadling")
        check_size(picks, ends)
        self.check_shafts(threading, sheds)
        drawdown = self.drawdown(threading, sheds, picks, ends)
        lengths = self.lengths(picks, ends)
        table = self.table()
        colors = {}
        if table:
            colors["warp_colors"] = self.colors("WARP", table, ends)
            colors["weft_colors"] = self.colors("WEFT", table, picks)
        entry = self.entry("TEXT", "title")
        name = one_line(entry.text) if entry else title
        return Draft(drawdown, **lengths, **colors, title=name, warnings=tuple(dict.fromkeys(self.warnings)))

    # -- entries -------------------------------------------------------------------------------------------------------

    def entry(self, section: str, key: str) -> _Entry | None:
        """What stands behind a key without its comment; None for nothing."""
        entry = self.sections.get(section, {}).get(key)
        text = entry.text.split(";")[0].strip() if entry else ""
        return _Entry(text, entry.line) if text else None

    def numbered(self, section: str) -> Iterable[tuple[int, _Entry]]:
        """(number of the thread, treadle or colour, its entry) of the lines of a section; an entry may be empty."""
        for key, entry in self.sections.get(section, {}).items():
            if key.isdecimal() and key.isascii():
                if len(key) > 9 or int(key) < 1:
                    _fail(section, key[:20], entry, "a line numbered from 1")
                yield int(key), _Entry(entry.text.split(";")[0].strip(), entry.line)

    def integer(self, section: str, key: str) -> int | None:
        """A whole number; None for nothing and for 0."""
        entry = self.entry(section, key)
        return (_integers(section, key, entry)[0] or None) if entry else None

    def lists(self, section: str) -> dict[int, list[int]]:
        """{thread: numbers above 0} of a section; 0 and nothing are none."""
        return {k: [n for n in _integers(section, k, e) if n] if e.text else [] for k, e in self.numbered(section)}

    # -- interlacing -----------------------------------------------------------------------------------------------------

    def sheds(self) -> tuple[dict[int, list[int]], int]:
        """({pick: shafts that its treadles move}, the last pick about which something is said)."""
        tieup, treadling, lift = self.lists("TIEUP"), self.lists("TREADLING"), self.lists("LIFTPLAN")
        said = any(tieup.values()) and any(treadling.values())
        if said or (tieup and treadling and not lift):
            tied = {treadle: frozenset(shafts) for treadle, shafts in tieup.items()}
            if lost := {t for treadles in treadling.values() for t in treadles} - set(tied):
                self.warnings.append(f"[TREADLING]: treadle {min(lost)} has no line in [TIEUP]: it lifts no shaft")
            made: dict[tuple, list[int]] = {}  # picks repeat, so each combination of treadles is joined once
            for treadles in treadling.values():
                if (key := tuple(sorted(set(treadles)))) not in made:
                    if len(key) > MAX_SHAFTS or len(made) > MAX_THREADS:
                        raise InputError(f"[TREADLING]: more than {MAX_SHAFTS} treadles at once, expected a loom's")
                    made[key] = sorted(frozenset().union(*(tied.get(t, frozenset()) for t in key)))
            return {k: made[tuple(sorted(set(v)))] for k, v in treadling.items()}, max(treadling)
        if lift:
            return lift, max(lift)
        raise InputError(
            "has neither [TIEUP] with [TREADLING] nor [LIFTPLAN], so no shed opens; export the draft with one of them"
        )

    def counted(self, system: str, threads: int | None, last: int, what: str) -> int:
        """How many threads there are: as far as the draft goes, whatever Threads says."""
        if threads is not None and threads > last:
            self.warnings.append(f"{threads - last} {'ends' if system == 'WARP' else 'picks'} without {what} dropped")
        if threads is not None and threads < last:
            self.warnings.append(f"[{system}] Threads = {threads}, but {what} goes to {last}")
        return last

    def check_shafts(self, threading: dict[int, list[int]], sheds: dict[int, list[int]]) -> None:
        shafts = self.integer("WEAVING", "shafts")
        if shafts is None:
            return
        for section, rows in (("THREADING", threading), ("LIFTPLAN or TIEUP", sheds)):
            for k, used in rows.items():
                if used and max(used) > shafts:
                    where = f"[{section}] {'end' if section == 'THREADING' else 'pick'} {k}"
                    raise InputError(f"{where} is on shaft {max(used)}, expected 1 to {shafts} ([WEAVING] Shafts)")

    def drawdown(self, threading: dict, sheds: dict, picks: int, ends: int) -> np.ndarray:
        """bool [picks, ends]: an end is up where one of its shafts is; ends on no shaft stay down."""
        shafts = sorted({s for used in threading.values() for s in used})
        if len(shafts) > MAX_SHAFTS:
            raise InputError(f"[THREADING] names {len(shafts)} shafts, expected at most {MAX_SHAFTS}; give one repeat")
        column = {shaft: i for i, shaft in enumerate(shafts)}
        on, up = (np.zeros((n, len(shafts)), np.float32) for n in (ends, picks))
        for matrix, rows in ((on, threading), (up, sheds)):
            for k, used in rows.items():
                if k <= len(matrix):
                    matrix[k - 1, [column[s] for s in used if s in column]] = 1.0
        raised = up @ on.T > 0.5
        # The 1997 text has sinking sheds as the default; files that say nothing mean rising ones.
        return raised if self.rising() else ~raised & (on.any(1))

    def rising(self) -> bool:
        entry = self.entry("WEAVING", "rising shed")
        if entry is None:
            return True
        if entry.text.lower() not in WORDS:
            _fail("WEAVING", "Rising Shed", entry, "true or false")
        return WORDS[entry.text.lower()]

    # -- threads ---------------------------------------------------------------------------------------------------------

    def lengths(self, picks: int, ends: int) -> dict[str, np.ndarray]:
        """Spacing and thickness of all threads in cm; a system without spacing has the other's, none the usual one."""
        spacing, thickness = {}, {}
        for system, count in (("warp", ends), ("weft", picks)):
            scale = self.unit(system.upper())
            spacing[system] = scale * self.row(system.upper(), "spacing", count)
            thickness[system] = scale * self.row(system.upper(), "thickness", count)
        known = np.concatenate(list(spacing.values()))
        known = known[np.isfinite(known)]
        if not known.size:
            self.warnings.append(f"no spacing is given: taken as {USUAL_CM} cm")
        elif not USUAL_SPACING[0] <= known.mean() <= USUAL_SPACING[1]:
            self.warnings.append(f"a spacing of {known.mean():.4g} cm is no cloth's; check Units or set the sett")
        usual = known.mean() if known.size else USUAL_CM
        out = {}
        for system in ("warp", "weft"):
            out[f"{system}_spacing"] = np.where(np.isfinite(spacing[system]), spacing[system], usual)
            known_width = np.isfinite(thickness[system])
            out[f"{system}_thickness"] = np.where(known_width, thickness[system], out[f"{system}_spacing"])
        return out

    def unit(self, system: str) -> float:
        entry = self.entry(system, "units")
        if entry and entry.text.lower() not in UNITS:
            self.warnings.append(f"[{system}] Units = {entry.text[:20]} is unknown: taken as centimeters")
        return UNITS.get(entry.text.lower(), 1.0) if entry else 1.0

    def row(self, system: str, what: str, count: int) -> np.ndarray:
        """[count] lengths in the file's unit, NaN where nothing is said."""
        entry = self.entry(system, what)
        out = np.full(count, _length(system, what, entry) if entry else np.nan)
        for k, own in self.numbered(f"{system} {what.upper()}"):
            if own.text and k <= count:
                out[k - 1] = _length(f"{system} {what.upper()}", k, own)
        return out

    # -- colours ---------------------------------------------------------------------------------------------------------

    def table(self) -> dict[int, np.ndarray]:
        """{index: linear colour}; display values are scaled by Range."""
        section = "COLOR TABLE"
        table = {k: _reals(section, k, entry, 3) for k, entry in self.numbered(section) if entry.text}
        if not table:
            return {}
        entry = self.entry("COLOR PALETTE", "range")
        bounds = _reals("COLOR PALETTE", "Range", entry, 1)[:2] if entry else [0.0, 255.0]
        low, high = (0.0, bounds[0]) if len(bounds) == 1 else bounds
        if not high > low:
            _fail("COLOR PALETTE", "Range", entry, "the lowest and the highest value, such as 0,255")
        largest = max(v for color in table.values() for v in color[:3])
        if largest > high:
            self.warnings.append(f"colours go beyond Range: taken as {low:g} to {largest:g}")
            high = largest
        return {k: srgb_decode(np.clip((np.array(v[:3]) - low) / (high - low), 0.0, 1.0)) for k, v in table.items()}

    def colors(self, system: str, table: dict[int, np.ndarray], count: int) -> np.ndarray:
        """[count, 3] linear colours. Old files write `index,R,G,B`: the index counts."""
        grey = srgb_decode(np.full(3, DEFAULT_COLOR))
        default = self.integer(system, "color")
        if default is not None and default not in table:
            self.warnings.append(f"[{system}] Color = {default} is not in the colour table: taken as light grey")
        out = np.tile(table.get(default, grey), (count, 1))
        for k, entry in self.numbered(f"{system} COLORS"):
            index = _integers(f"{system} COLORS", k, entry)[0] if entry.text else 0
            if index and k <= count:
                if index in table:
                    out[k - 1] = table[index]
                else:
                    self.warnings.append(f"[{system} COLORS] names colour {index}, which is not in the table")
        return out


def _parts(text: str) -> list[str]:
    return [part for part in re.split(r"[,\s]+", text) if part]


def _integers(section: str, key, entry: _Entry) -> list[int]:
    """One or more whole numbers from 0."""
    parts = _parts(entry.text)
    if not parts or not all(re.fullmatch(r"\+?[0-9]{1,9}(\.0*)?", part) for part in parts):
        _fail(section, key, entry, "whole numbers from 0, with commas between")
    return [int(float(part)) for part in parts]


def _reals(section: str, key, entry: _Entry, least: int) -> list[float]:
    """At least `least` finite numbers from 0."""
    parts = _parts(entry.text)
    good = len(parts) >= least and all(re.fullmatch(r"\+?([0-9]{1,9}\.?[0-9]{0,20}|\.[0-9]{1,20})", p) for p in parts)
    if not good:
        _fail(section, key, entry, f"{least} numbers from 0" if least > 1 else "numbers from 0")
    return [float(part) for part in parts]


def _length(section: str, key, entry: _Entry) -> float:
    """A length in the file's unit, a decimal comma allowed; NaN for 0, which means none."""
    pattern = r"\+?([0-9]{1,9}([.,][0-9]{0,20})?|[.,][0-9]{1,20})(e[-+]?[0-9]{1,2})?"
    if not re.fullmatch(pattern, entry.text, re.IGNORECASE):
        _fail(section, key, entry, "a length above 0")
    return float(entry.text.replace(",", ".")) or np.nan


def save_draft(path: str | Path, draft: Draft) -> None:
    """Write a draft as WIF 1.1 with tie-up and treadling; `load_draft` reads it back.

    Ends that work alike share a shaft, picks that are alike a treadle. Raises InputError if the file cannot be written.
    """
    with atomic_write(path) as temporary:
        temporary.write_bytes(draft_text(draft).encode("utf-8"))


def draft_text(draft: Draft) -> str:
    """The text of a WIF file that holds `draft`."""
    columns, shaft = np.unique(draft.drawdown.T, axis=0, return_inverse=True)
    rows, treadle = np.unique(columns.T, axis=0, return_inverse=True)
    sections: dict[str, dict] = {
        "WIF": {"Version": 1.1, "Date": "April 20, 1997", "Developers": "wif@mhsoft.com", "Source Program": "glcloth"},
        "CONTENTS": {},
        "TEXT": {"Title": one_line(draft.title)},
        "WEAVING": {"Rising Shed": "true", "Shafts": len(columns), "Treadles": len(rows)},
        "WARP": {"Threads": draft.ends, "Units": "centimeters"},
        "WEFT": {"Threads": draft.picks, "Units": "centimeters"},
        "THREADING": _lines(s + 1 for s in shaft.ravel()),
        "TIEUP": _lines(",".join(str(s + 1) for s in np.flatnonzero(row)) for row in rows),
        "TREADLING": _lines(t + 1 for t in treadle.ravel()),
    }
    for system in ("warp", "weft"):
        for what in ("spacing", "thickness"):
            values = getattr(draft, f"{system}_{what}")
            sections[system.upper()][what.title()] = repr(float(values[0]))
            if (values != values[0]).any():
                sections[f"{system.upper()} {what.upper()}"] = _lines(repr(float(v)) for v in values)
    if draft.has_colors:
        codes = {s: np.rint(255 * srgb_encode(getattr(draft, f"{s}_colors"))).astype(int) for s in ("warp", "weft")}
        table, index = np.unique(np.concatenate(list(codes.values())), axis=0, return_inverse=True)
        index = index.ravel() + 1
        sections["COLOR PALETTE"] = {"Range": "0,255", "Entries": len(table)}
        sections["COLOR TABLE"] = _lines(",".join(map(str, color)) for color in table)
        for system, numbers in (("WARP", index[: draft.ends]), ("WEFT", index[draft.ends :])):
            sections[system]["Color"] = int(numbers[0])
            if (numbers != numbers[0]).any():
                sections[f"{system} COLORS"] = _lines(numbers)
    sections["CONTENTS"] = dict.fromkeys((name for name in sections if name not in ("WIF", "CONTENTS")), "true")
    body = ("\n".join([f"[{name}]", *(f"{k}={v}" for k, v in lines.items())]) for name, lines in sections.items())
    return "\n\n".join(body) + "\n"


def _lines(values: Iterable) -> dict[int, object]:
    return dict(enumerate(values, 1))
