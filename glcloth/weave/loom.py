"""A drawdown as a loom makes it: which shaft each end is on, which treadle each pick steps on, and what that lifts."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from .draft import Draft


@dataclass(frozen=True, eq=False)
class Loom:
    """A loom of `shafts` and `treadles`, all counted from 0.

    threading : int [ends], the shaft of each end. treadling : int [picks], the treadle of each pick.
    tieup : bool [treadles, shafts], True where a treadle lifts a shaft. Shafts and treadles may be unused.
    """

    threading: np.ndarray
    treadling: np.ndarray
    tieup: np.ndarray

    @staticmethod
    def of(drawdown: np.ndarray) -> Loom:
        """The smallest loom that weaves a drawdown [picks, ends]: ends that work alike share a shaft, equal picks a treadle.

        Shafts and treadles are numbered as they appear, so that twills are threaded straight.
        """
        columns, threading = _in_order(drawdown.T)
        rows, treadling = _in_order(columns.T)
        return Loom(threading, treadling, rows)

    @property
    def shafts(self) -> int:
        return self.tieup.shape[1]

    @property
    def treadles(self) -> int:
        return self.tieup.shape[0]

    @property
    def drawdown(self) -> np.ndarray:
        """bool [picks, ends], True where the warp is on top."""
        return self.tieup[np.ix_(self.treadling, self.threading)]

    def crossed(self, pick: int, end: int, up: bool) -> Loom:
        """The loom of the drawdown in which this one crossing is up or down."""
        drawdown = self.drawdown
        if drawdown[pick, end] == up:
            return self
        drawdown[pick, end] = up
        return Loom.of(drawdown)

    def threaded(self, end: int, shaft: int) -> Loom:
        """An end on another shaft; the one after the last is new and tied to nothing."""
        grown = self._grown(self.treadles, shaft + 1)
        return replace(grown, threading=_with(self.threading, end, shaft))

    def trodden(self, pick: int, treadle: int) -> Loom:
        """A pick on another treadle; the one after the last is new and lifts nothing."""
        grown = self._grown(treadle + 1, self.shafts)
        return replace(grown, treadling=_with(self.treadling, pick, treadle))

    def tied(self, treadle: int, shaft: int, up: bool) -> Loom:
        """A treadle that lifts a shaft, or does not."""
        tieup = self.tieup.copy()
        tieup[treadle, shaft] = up
        return replace(self, tieup=tieup)

    def resized(self, picks: int, ends: int) -> Loom:
        """As many picks and ends; those that are new repeat the first ones."""
        return replace(self, threading=np.resize(self.threading, ends), treadling=np.resize(self.treadling, picks))

    def _grown(self, treadles: int, shafts: int) -> Loom:
        more = max(treadles - self.treadles, 0), max(shafts - self.shafts, 0)
        return replace(self, tieup=np.pad(self.tieup, ((0, more[0]), (0, more[1])))) if any(more) else self

    def draft(self, like: Draft) -> Draft:
        """The drawdown as a draft whose threads are those of `like`, repeated."""
        drawdown = self.drawdown
        return replace(like.sized(*drawdown.shape, drawdown), warnings=())


def _in_order(rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The distinct rows in the order of their first appearance, and the number of each row's."""
    distinct, first, number = np.unique(rows, axis=0, return_index=True, return_inverse=True)
    order = np.argsort(first)
    rank = np.empty(len(order), int)
    rank[order] = np.arange(len(order))
    return distinct[order], rank[number.ravel()]


def _with(numbers: np.ndarray, at: int, value: int) -> np.ndarray:
    out = numbers.copy()
    out[at] = value
    return out
