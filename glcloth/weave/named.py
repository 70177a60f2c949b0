"""The weaves that have names, each as the drawdown of one repeat: bool [picks, ends], True where the warp is on top.

Rows are picks from the top, columns are ends from the left. Sources: Oelsner 1915, "A Handbook of Weaves"; Watson 1912,
"Textile Design and Colour" (both in the public domain).
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..errors import InputError, meant
from .draft import USUAL_CM, Draft
from .figures import damask_figure, lace_cut


def twill(*floats: int, step: int = 1) -> np.ndarray:
    """A twill whose ends go over, under, over ... `floats` picks, each end `step` picks above its left neighbour.

    twill(2, 2) is the 2/2 twill. The line climbs to the right. Returns [n, n] with n = sum(floats).
    """
    n = sum(floats)
    column = np.repeat(np.arange(len(floats)) % 2 == 0, floats)
    return np.stack([np.roll(column, -step * end) for end in range(n)], 1)


def satin(n: int, step: int) -> np.ndarray:
    """The n-end warp satin: each end goes under one pick, `step` picks away from that of its left neighbour.

    `step` has no factor in common with n and is neither 1 nor n - 1. Returns [n, n].
    """
    under = np.zeros((n, n), bool)
    under[np.arange(n) * step % n, np.arange(n)] = True
    return ~under


def plain() -> np.ndarray:
    """Over one, under one."""
    return twill(1, 1)


def basket(warp: int = 2, weft: int = 2) -> np.ndarray:
    """Plain weave with `warp` ends and `weft` picks together (matt, hopsack, panama)."""
    return np.repeat(np.repeat(plain(), weft, 0), warp, 1)


def oxford() -> np.ndarray:
    """Two ends together over one pick."""
    return basket(2, 1)


def rib(picks: int = 2) -> np.ndarray:
    """Warp rib: `picks` picks in each shed, so that the ends float over them and ribs run across."""
    return basket(1, picks)


def pointed(weave: np.ndarray, ends: int) -> np.ndarray:
    """`ends` ends of a weave, then as many of its mirror image with up and down exchanged: a herringbone.

    The exchange makes a clean cut at each turn, as in herringbone tweed. `ends` is a multiple of the weave's ends.
    """
    there = np.tile(weave, (1, -(-ends // weave.shape[1])))[:, :ends]
    return np.concatenate([there, ~there[:, ::-1]], 1)


def herringbone() -> np.ndarray:
    """2/2 twill that turns every eight ends."""
    return pointed(twill(2, 2), 8)


def damask() -> np.ndarray:
    """A figure in warp satin on a ground of weft satin of five."""
    figure = damask_figure()
    repeats = np.array(figure.shape) // 5
    return np.where(figure, np.tile(satin(5, 2), repeats), np.tile(~satin(5, 2)[:, ::-1], repeats))


def lace() -> np.ndarray:
    """Plain weave, out of which `lace_cut` takes a net, flowers and eyelets."""
    return np.tile(plain(), np.array(lace_cut().shape) // 2)


def pile(n: int = 48) -> np.ndarray:
    """Tufts of velvet, which lean otherwise at every place of the repeat: [n, n]."""
    return np.tile(plain(), (n // 2, n // 2))


def mock_leno(n: int = 3) -> np.ndarray:
    """Groups of `n` threads that draw together, with slits between the groups (canvas weave, cellular cloth).

    Inside a group the middle ends float over all picks and the outer two weave plain; the next group is the opposite,
    so that neighbours across the slit never lie side by side in one shed. Returns [2 n, 2 n], n odd.
    """
    group = np.ones((n, n), bool)
    group[1::2, [0, -1]] = False
    return np.block([[group, ~group], [~group, group]])


def honeycomb(n: int = 8) -> np.ndarray:
    """Waffle: a diamond of growing warp floats, a line of single crossings about it, weft floats between. [n, n], n even."""
    from_middle = np.abs(np.arange(n) - n // 2)
    ring = from_middle[:, None] + from_middle
    return (ring == n // 2) | (ring < n // 2 - 1)


def crepe() -> np.ndarray:
    """An irregular weave of short floats without lines (sateen derivative, 8 ends): a pebbled face."""
    spots = ~satin(8, 3)
    return spots | np.roll(spots, 1, 0) | np.roll(spots, 3, 1) | np.roll(spots, 4, 0)


WEAVES: dict[str, Callable[[], np.ndarray]] = {
    "plain": plain,
    "basket": basket,
    "oxford": oxford,
    "rib": rib,
    "twill_2_1": lambda: twill(2, 1),
    "twill_1_2": lambda: twill(1, 2),
    "twill_2_2": lambda: twill(2, 2),
    "twill_3_1": lambda: twill(3, 1),
    "twill_1_3": lambda: twill(1, 3),
    "herringbone": herringbone,
    "houndstooth": lambda: twill(2, 2),
    "satin_5": lambda: satin(5, 2),
    "satin_8": lambda: satin(8, 3),
    "sateen_5": lambda: ~satin(5, 2),
    "sateen_8": lambda: ~satin(8, 3),
    "damask": damask,
    "lace": lace,
    "mock_leno": mock_leno,
    "pile": pile,
    "honeycomb": honeycomb,
    "crepe": crepe,
}

GROUP = (1.44, 0.12, 1.44)  # room of the three threads of a group: they lie 0.78 apart, and the groups 1.44
DARK, LIGHT = (0.02, 0.02, 0.022), (0.70, 0.66, 0.56)  # the two colours that make a houndstooth


def named_draft(name: str) -> Draft:
    """The draft of one repeat of a named weave, without colours but for houndstooth: four dark, four light, both ways.
    Mock leno has the spacing of its groups, lace its holes, pile its tufts.

    Raises InputError for an unknown name, with a suggestion.
    """
    if name not in WEAVES:
        hint = meant(name, WEAVES, '; did you mean "{}"?')
        raise InputError(f'weave "{name}": not a named weave ({", ".join(WEAVES)}) and not a .wif file{hint}')
    drawdown = WEAVES[name]()
    if name == "lace":
        return Draft(drawdown, cut=lace_cut(), title=name)
    if name == "pile":
        return Draft(drawdown, pile=True, title=name)
    if name == "mock_leno":
        # The threads of a group close up, and leave slits between the groups.
        spacing = USUAL_CM * np.tile(GROUP, 2)
        return Draft(drawdown, spacing, spacing, np.full(6, USUAL_CM), np.full(6, USUAL_CM), title=name)
    if name != "houndstooth":
        return Draft(drawdown, title=name)
    colors = np.repeat([DARK, LIGHT], 4, 0)
    return Draft(np.tile(drawdown, (2, 2)), warp_colors=colors, weft_colors=colors, title=name)
