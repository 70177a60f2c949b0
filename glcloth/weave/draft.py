"""A weaver's draft as a plain value: which threads lie on top, how far apart and how thick they are, and their colours."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from ..color import srgb_decode, srgb_encode
from ..errors import InputError

MAX_THREADS = 16384  # ends, and picks, of a whole draft
MAX_CROSSINGS = 1 << 24  # ends times picks of a whole draft
MAX_REPEAT = 1 << 20  # crossings of one repeat of the structure, 1024 x 1024
USUAL_CM = 0.05  # spacing of threads about which nothing is said: 20 a centimetre


@dataclass(frozen=True, eq=False)
class Draft:
    """A draft of `ends` warp threads and `picks` weft threads; ends count from the left, picks from the top.

    drawdown : bool [picks, ends], True where the warp is on top.
    warp_spacing, weft_spacing : float64 [ends], [picks], cm from centre to centre (1 / sett).
    warp_thickness, weft_thickness : float64 [ends], [picks], cm, width of the threads; spacing where not given.
    warp_colors, weft_colors : float64 [ends, 3], [picks, 3], linear Rec. 709, or both None; kept as display sRGB of 8 bits,
    as drafts state colours.
    cut : bool [picks, ends], True where both threads are missing, as in eyelets and lace, or None; files other than
    fabrics cannot say it.
    pile : the crossings are tufts of a cut pile, which hides the weave; nothing of it repeats.
    title, warnings : text; what was odd about the file.

    Arrays are read-only. Raises InputError for other shapes, values that are no lengths or colours, and sizes above
    16384 threads, 2^24 crossings or a repeat of 2^20 crossings.
    """

    drawdown: np.ndarray
    warp_spacing: np.ndarray | None = None
    weft_spacing: np.ndarray | None = None
    warp_thickness: np.ndarray | None = None
    weft_thickness: np.ndarray | None = None
    warp_colors: np.ndarray | None = None
    weft_colors: np.ndarray | None = None
    cut: np.ndarray | None = None
    pile: bool = False
    title: str = ""
    warnings: tuple[str, ...] = field(default=())

    def __post_init__(self):
        drawdown = np.asarray(self.drawdown)
        if drawdown.ndim != 2 or 0 in drawdown.shape or drawdown.dtype != bool:
            raise InputError(f"draft: drawdown is {drawdown.dtype} {drawdown.shape}, expected bool [picks, ends]")
        check_size(*drawdown.shape)
        self._keep("drawdown", drawdown)
        if self.cut is not None:
            cut = np.asarray(self.cut)
            if cut.shape != drawdown.shape or cut.dtype != bool or cut.all():
                raise InputError("draft: cut: expected bool [picks, ends], as the drawdown, that leaves some cloth")
            self._keep("cut", cut)
        picks, ends = drawdown.shape
        for system, count in (("warp", ends), ("weft", picks)):
            spacing = _lengths(f"{system}_spacing", getattr(self, f"{system}_spacing"), np.full(count, USUAL_CM))
            self._keep(f"{system}_spacing", spacing)
            thickness = _lengths(f"{system}_thickness", getattr(self, f"{system}_thickness"), spacing)
            self._keep(f"{system}_thickness", thickness)
        if (self.warp_colors is None) != (self.weft_colors is None):
            raise InputError("draft: only one of warp_colors and weft_colors is given, expected both or none")
        if self.warp_colors is not None:
            self._keep("warp_colors", _colors("warp_colors", self.warp_colors, ends))
            self._keep("weft_colors", _colors("weft_colors", self.weft_colors, picks))
        if self.structure[0] * self.structure[1] > MAX_REPEAT:
            size = f"{self.structure[1]} ends x {self.structure[0]} picks"
            raise InputError(f"draft: the repeat has {size}, expected at most {MAX_REPEAT} crossings; cut the draft")

    def _keep(self, name: str, array: np.ndarray) -> None:
        array = np.array(array)
        array.flags.writeable = False
        object.__setattr__(self, name, array)

    @property
    def picks(self) -> int:
        """Number of weft threads."""
        return self.drawdown.shape[0]

    @property
    def ends(self) -> int:
        """Number of warp threads."""
        return self.drawdown.shape[1]

    @property
    def has_colors(self) -> bool:
        """Whether the draft says the colours of its threads."""
        return self.warp_colors is not None

    @cached_property
    def structure(self) -> tuple[int, int]:
        """(picks, ends) of the smallest repeat of interlacing, spacing and thickness."""
        if self.pile:
            return self.drawdown.shape
        weft, warp = self._threads()
        return period(weft), period(warp)

    @cached_property
    def colors_repeat(self) -> tuple[int, int]:
        """(picks, ends) of the smallest repeat of the colours alone; (1, 1) without colours."""
        return (period(self.weft_colors), period(self.warp_colors)) if self.has_colors else (1, 1)

    @property
    def repeat(self) -> tuple[int, int]:
        """(picks, ends) of the smallest repeat of everything; it divides the draft."""
        (p, e), (q, f) = self.structure, self.colors_repeat
        return int(np.lcm(p, q)), int(np.lcm(e, f))

    def reduced(self) -> Draft:
        """One repeat of the draft: an equal cloth, of which nothing repeats."""
        return self.sized(*self.repeat)

    def sized(self, picks: int, ends: int, drawdown: np.ndarray | None = None) -> Draft:
        """The first `picks` and `ends` of the draft, which repeats where they are more; they weave another drawdown where one
        is given."""
        pick, end = np.arange(picks) % self.picks, np.arange(ends) % self.ends
        parts = {
            f"{system}_{what}": None if (value := getattr(self, f"{system}_{what}")) is None else value[threads]
            for system, threads in (("warp", end), ("weft", pick))
            for what in ("spacing", "thickness", "colors")
        }
        at = np.ix_(pick, end)
        own = self.drawdown[at] if drawdown is None else drawdown
        return replace(self, drawdown=own, cut=None if self.cut is None else self.cut[at], **parts)

    def flipped(self) -> Draft:
        """The draft read from the bottom, as handweavers often weave: twill lines lean the other way."""
        weft = {f"weft_{what}": getattr(self, f"weft_{what}") for what in ("spacing", "thickness", "colors")}
        weft = {name: None if value is None else value[::-1] for name, value in weft.items()}
        cut = None if self.cut is None else self.cut[::-1]
        return replace(self, drawdown=self.drawdown[::-1], cut=cut, **weft)

    def _threads(self) -> tuple[np.ndarray, np.ndarray]:
        """Everything but colour that tells one thread from another: a row for each pick, a row for each end."""
        crossings = self.drawdown if self.cut is None else self.drawdown + 2 * self.cut
        weft = np.column_stack([crossings, self.weft_spacing, self.weft_thickness])
        warp = np.column_stack([crossings.T, self.warp_spacing, self.warp_thickness])
        return weft, warp

    def _key(self) -> tuple:
        arrays = (self.drawdown, self.warp_spacing, self.weft_spacing, self.warp_thickness, self.weft_thickness)
        arrays += (self.warp_colors, self.weft_colors, self.cut)
        return (self.title, self.pile, *((None if a is None else (a.shape, a.tobytes())) for a in arrays))

    def __eq__(self, other) -> bool:
        return isinstance(other, Draft) and self._key() == other._key()

    def __hash__(self) -> int:
        return self._hash

    @cached_property
    def _hash(self) -> int:
        return hash(self._key())


def check_size(picks: int, ends: int) -> None:
    """Raise InputError for a draft larger than anything woven, before memory is taken for it."""
    if max(picks, ends) > MAX_THREADS or picks * ends > MAX_CROSSINGS:
        most = f"at most {MAX_THREADS} threads a side and {MAX_CROSSINGS} crossings"
        raise InputError(f"draft: {ends} ends x {picks} picks, expected {most}; give one repeat")


def period(rows: np.ndarray) -> int:
    """The least number of rows that, repeated a whole number of times, gives `rows` [n, ...]; n where nothing repeats."""
    n = len(rows)
    flat = np.ascontiguousarray(rows).reshape(n, -1)
    _, numbers = np.unique(flat, axis=0, return_inverse=True)
    numbers = numbers.ravel()
    return next(p for p in range(1, n + 1) if n % p == 0 and np.array_equal(numbers[p:], numbers[: n - p]))


def _lengths(name: str, value, default: np.ndarray) -> np.ndarray:
    value = default if value is None else np.asarray(value, float)
    if value.shape != default.shape:
        raise InputError(f"draft: {name} has shape {value.shape}, expected {default.shape}, one for each thread")
    if not (np.isfinite(value) & (value > 0.0)).all():
        raise InputError(f"draft: {name} holds values that are no lengths, expected centimetres above 0")
    return value


def _colors(name: str, value, count: int) -> np.ndarray:
    value = np.asarray(value, float)
    if value.shape != (count, 3):
        raise InputError(f"draft: {name} has shape {value.shape}, expected ({count}, 3), one colour for each thread")
    if not ((value >= 0.0) & (value <= 1.0)).all():
        raise InputError(f"draft: {name} holds values outside 0 to 1, expected linear Rec. 709")
    return srgb_decode(np.rint(255.0 * srgb_encode(value)) / 255.0)
