"""Lines of text files as arrays of bytes: found, joined and parsed together."""

from __future__ import annotations

import re
import warnings
from functools import cached_property

import numpy as np

from ..errors import InputError

NEWLINE, TAB, SPACE, SLASH = 10, 9, 32, 47
NAMED = ("usemtl", "mtllib", "o", "g")
CONTINUED = re.compile(rb"(?:[^\n]*\\[ \t]*\n)+[^\n]*")
COMMENT = re.compile(rb"#[^\n]*")


def plain(blob: bytes) -> bytes:
    """The bytes of a text file in a code that holds ASCII, without byte order marks, each line ended by a newline."""
    if blob[:2] in (b"\xff\xfe", b"\xfe\xff"):
        blob = blob.decode("utf-16", errors="replace").encode()
    blob = blob.replace(b"\xef\xbb\xbf", b"")
    return blob.replace(b"\r\n", b"\n").replace(b"\r", b"\n") if b"\r" in blob else blob


class Lines:
    """The lines of a file such as OBJ: a word that says what it is, and others. A `\\` at the end continues a line.

    Numbers of lines count from 0 and are those of the file.
    """

    def __init__(self, blob: bytes, where: str):
        self.where = where
        blob = plain(blob)
        if b"\\\n" in blob or b"\\ " in blob:
            blob = CONTINUED.sub(_joined, blob)
        self.blob = blob
        self._codes = np.frombuffer(blob + b"\n" + 8 * b" ", np.uint8)
        self._ends = np.flatnonzero(self._codes == NEWLINE)
        self._begins = np.concatenate([[0], self._ends[:-1] + 1])
        self._words = self._begins.copy()  # where the first word of each line begins
        begin = self._codes[self._begins]
        for line in np.flatnonzero((begin == TAB) | (begin == SPACE)).tolist():
            text = self.text(line)
            self._words[line] += len(text) - len(text.lstrip())

    def text(self, line: int) -> bytes:
        """The bytes of a line."""
        return self.blob[self._begins[line] : self._ends[line]]

    def words(self, line: int) -> list[str]:
        """The words of a line."""
        return self.text(line).split(b"#", 1)[0].decode("utf-8", errors="replace").split()

    @cached_property
    def _initials(self) -> np.ndarray:
        """The first two letters [L] of each line's first word, as one number."""
        return self._codes[self._words].astype(np.uint16) * 256 + self._codes[self._words + 1]

    def that_begin(self, word: str) -> np.ndarray:
        """The lines [L] whose first word this is."""
        code = word.encode()
        if len(code) == 1:
            blank = [self._initials == code[0] * 256 + c for c in (SPACE, TAB, NEWLINE)]
            return np.flatnonzero(blank[0] | blank[1] | blank[2])
        lines = np.flatnonzero(self._initials == code[0] * 256 + code[1])
        for k, letter in enumerate(code[2:], 2):
            lines = lines[self._codes[self._words[lines] + k] == letter]
        after = self._codes[self._words[lines] + len(code)]
        return lines[(after == SPACE) | (after == TAB) | (after == NEWLINE)]

    @cached_property
    def named(self) -> list[tuple[int, str, str]]:
        """(line, its first word, the rest) of all lines that give or use a name. A ` # ` begins a comment."""
        lines = sorted((line, word) for word in NAMED for line in self.that_begin(word).tolist())
        rest = [self.text(line).strip()[len(word) :].split(b" # ", 1)[0].strip() for line, word in lines]
        return [(line, word, r.decode("utf-8", errors="replace")) for (line, word), r in zip(lines, rest, strict=True)]

    def joined(self, lines: np.ndarray, skip: int) -> Words:
        """The words of lines but for their first one, of `skip` letters."""
        apart = np.flatnonzero(np.diff(lines) != 1)
        begins = self._begins[lines[np.concatenate([[0], apart + 1])]]
        ends = self._ends[lines[np.concatenate([apart, [len(lines) - 1]])]] + 1
        blob = bytearray().join(self.blob[a:b] for a, b in zip(begins.tolist(), ends.tolist(), strict=True))
        if ends[-1] > len(self.blob):  # the last line has no end
            blob += b"\n"
        lengths = ends - begins
        moved = np.repeat(
            np.cumsum(lengths) - lengths - begins, np.diff(np.concatenate([[0], apart + 1, [len(lines)]]))
        )
        first = self._words[lines] + moved
        codes = np.frombuffer(blob, np.uint8)
        for k in range(skip):
            codes[first + k] = SPACE
        return Words(bytes(blob))

    def fault(self, line: int, what: str, whole: bool = False) -> InputError:
        """An error about a line; `whole`: that quotes it."""
        quoted = f" `{self.text(line).decode('utf-8', errors='replace').strip()}`:" if whole else ""
        return InputError(f"{self.where}:{line + 1}:{quoted} {what}")


def _joined(match: re.Match) -> bytes:
    """A continued line in one, and as many empty ones after it as it took."""
    pieces = match[0].split(b"\n")
    return b" ".join(re.sub(rb"\\[ \t]*$", b"", piece) for piece in pieces) + b"\n" * (len(pieces) - 1)


class Words:
    """The words of lines, each line ended by a newline; comments are left out."""

    def __init__(self, blob: bytes):
        if b"#" in blob:
            blob = COMMENT.sub(lambda match: b" " * len(match[0]), blob)
        self.blob = blob
        self._codes = np.frombuffer(blob, np.uint8)
        blank = self._codes <= SPACE
        begins = ~blank
        begins[1:] &= blank[:-1]
        self._begins = np.flatnonzero(begins)

    def words_per_line(self) -> np.ndarray:
        """How many words each line has."""
        ends = np.flatnonzero(self._codes == NEWLINE)
        return np.diff(np.searchsorted(self._begins, ends), prepend=0)

    def floats(self) -> np.ndarray:
        """The words as numbers; fewer where one of them is none."""
        return parsed(self.blob, np.float64)

    def slashes(self) -> tuple[np.ndarray, np.ndarray, bool]:
        """How many slashes each word has, how many that follow another, and whether any word begins or ends with one."""
        at, count = np.flatnonzero(self._codes == SLASH), len(self._begins)
        if not len(at):
            none = np.zeros(count, np.int8)
            return none, none, False
        after, before = self._codes[at + 1], self._codes[at - 1]
        dangling = bool(((after <= SPACE) | (before <= SPACE)).any() or at[0] == 0)
        each = len(at) // max(count, 1)
        rows = at.reshape(count, each) if each * count == len(at) else None
        if rows is not None and (rows > self._begins[:, None]).all() and (rows[:-1] < self._begins[1:, None]).all():
            return np.full(count, each), (before == SLASH).reshape(count, each).sum(1), dangling
        word = np.searchsorted(self._begins, at, "right") - 1
        return np.bincount(word, minlength=count), np.bincount(word[before == SLASH], minlength=count), dangling

    def integers(self) -> np.ndarray:
        """The whole numbers between blanks and slashes; fewer where a word is none."""
        return parsed(self.blob.replace(b"/", b" "), np.int64)


def parsed(blob: bytes, kind: type) -> np.ndarray:
    """Numbers of a text; an older NumPy stops with a warning where a newer one raises ValueError."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return np.fromstring(blob, kind, sep=" ")
    except ValueError:
        return np.zeros(0, kind)
