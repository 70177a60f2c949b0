"""A draft as weavers draw it, in cells: threading above the drawdown, treadling beside it, the tie-up in the corner."""

from __future__ import annotations

from typing import Literal, NamedTuple

from ..weave.loom import Loom

Part = Literal["threading", "tieup", "drawdown", "treadling", "warp", "weft"]
FEWEST = 8  # rows for shafts, columns for treadles: the drawdown stays in its place while a loom of up to 8 changes


class Cell(NamedTuple):
    """A cell: of the threading (shaft, end), tie-up (shaft, treadle), drawdown (pick, end) or treadling (pick, treadle); or of
    the strips of colours, warp (0, end) and weft (pick, 0)."""

    part: Part
    row: int
    column: int


class Grid(NamedTuple):
    """Where the parts lie, in cells from the top left corner. Shaft 1 is the lowest row; a row of colours lies between."""

    ends: int
    picks: int
    shafts: int  # rows
    treadles: int  # columns

    @staticmethod
    def of(loom: Loom) -> Grid:
        """Room for a loom, and for one more shaft and treadle."""
        shafts, treadles = max(loom.shafts + 1, FEWEST), max(loom.treadles + 1, FEWEST)
        return Grid(len(loom.threading), len(loom.treadling), shafts, treadles)

    @property
    def size(self) -> tuple[int, int]:
        """Columns and rows of all parts."""
        return self.ends + 1 + self.treadles, self.shafts + 1 + self.picks

    def corner(self, cell: Cell) -> tuple[int, int]:
        """Column and row of the grid where a cell is."""
        if cell.part in ("warp", "weft"):
            return (cell.column, self.shafts) if cell.part == "warp" else (self.ends, self.shafts + 1 + cell.row)
        x = cell.column if cell.part in ("threading", "drawdown") else self.ends + 1 + cell.column
        y = self.shafts - 1 - cell.row if cell.part in ("threading", "tieup") else self.shafts + 1 + cell.row
        return x, y

    def cell(self, x: float, y: float) -> Cell | None:
        """The cell at a place, in cells from the corner; None between the parts and outside."""
        column, row = int(x // 1), int(y // 1)
        if not (0 <= column < self.size[0] and 0 <= row < self.size[1]):
            return None
        if row == self.shafts:
            return Cell("warp", 0, column) if column < self.ends else None
        if column == self.ends:
            return Cell("weft", row - self.shafts - 1, 0) if row > self.shafts else None
        left, top = column < self.ends, row < self.shafts
        column = column if left else column - self.ends - 1
        row = self.shafts - 1 - row if top else row - self.shafts - 1
        parts: dict[tuple[bool, bool], Part] = {
            (True, True): "threading", (False, True): "tieup", (True, False): "drawdown", (False, False): "treadling",
        }  # fmt: skip
        return Cell(parts[left, top], row, column)


def is_set(loom: Loom, cell: Cell) -> bool:
    """Whether a cell is marked: the warp is up, an end is on this shaft, a pick on this treadle, a treadle lifts it."""
    part, row, column = cell
    if part == "threading":
        return int(loom.threading[column]) == row
    if part == "treadling":
        return int(loom.treadling[row]) == column
    if part == "tieup":
        return row < loom.shafts and column < loom.treadles and bool(loom.tieup[column, row])
    if part in ("warp", "weft"):
        return True
    return bool(loom.tieup[loom.treadling[row], loom.threading[column]])


def said(loom: Loom, cell: Cell) -> str:
    """What a cell shows, in words."""
    part, row, column = cell
    if part == "threading":
        return f"end {column + 1} is on shaft {int(loom.threading[column]) + 1}"
    if part == "treadling":
        return f"pick {row + 1} steps on treadle {int(loom.treadling[row]) + 1}"
    if part == "tieup":
        return f"treadle {column + 1} {'lifts' if is_set(loom, cell) else 'leaves'} shaft {row + 1}"
    if part == "drawdown":
        return f"end {column + 1}, pick {row + 1}: {'warp' if is_set(loom, cell) else 'weft'} on top"
    thread = f"end {column + 1}" if part == "warp" else f"pick {row + 1}"
    return f"{thread}: drag the pen, right button: its colour"


def marked(loom: Loom, cell: Cell, up: bool) -> Loom:
    """The loom with a cell marked or not. An end is always on one shaft, a pick on one treadle: there `up` says nothing.

    A tie-up of a shaft or treadle that the loom does not have changes nothing; the next new one may be threaded.
    """
    part, row, column = cell
    if part == "threading":
        return loom if row > loom.shafts else loom.threaded(column, row)
    if part == "treadling":
        return loom if column > loom.treadles else loom.trodden(row, column)
    if part == "tieup":
        return loom.tied(column, row, up) if row < loom.shafts and column < loom.treadles else loom
    return loom.crossed(row, column, up)


def between(a: Cell, b: Cell) -> list[Cell]:
    """The cells from a to b, without a: the pointer may pass several between two looks."""
    steps = max(abs(b.row - a.row), abs(b.column - a.column), 1)
    return [
        Cell(b.part, round(a.row + (b.row - a.row) * k / steps), round(a.column + (b.column - a.column) * k / steps))
        for k in range(1, steps + 1)
    ]
