"""A draft as strings, numbers and lists, so that fabric files and pictures' headers can hold it."""

from __future__ import annotations

import re

import numpy as np

from ..color import srgb_decode, srgb_encode
from ..errors import InputError, one_line
from .draft import Draft

UP, DOWN, CUT = "#", ".", "o"
ARRAYS = tuple(f"{system}_{what}" for system in ("warp", "weft") for what in ("spacing", "thickness", "colors"))


def plain_draft(draft: Draft) -> dict:
    """{"drawdown": rows of # (warp on top), . and o (cut out), "warp_spacing": cm, "warp_colors": "#rrggbb", ...}; else lists."""
    out: dict = {"title": draft.title} if draft.title else {}
    signs = np.where(draft.drawdown, UP, DOWN)
    out["drawdown"] = ["".join(row) for row in (signs if draft.cut is None else np.where(draft.cut, CUT, signs))]
    if draft.pile:
        out["pile"] = True
    for name in ARRAYS:
        value = getattr(draft, name)
        if value is not None:
            values = [_hex(color) for color in value] if value.ndim == 2 else value.tolist()
            out[name] = values[0] if len(set(values)) == 1 else values
    return out


def _hex(color: np.ndarray) -> str:
    """Display sRGB as "#rrggbb"."""
    return "#{:02x}{:02x}{:02x}".format(*np.rint(255.0 * srgb_encode(color)).astype(int))


def _color(text: str) -> np.ndarray:
    """Linear Rec. 709 of "#rrggbb". Raises ValueError for anything else."""
    if not isinstance(text, str) or not re.fullmatch("#[0-9a-fA-F]{6}", text):
        raise ValueError(text)
    return srgb_decode(np.frombuffer(bytes.fromhex(text[1:]), np.uint8) / 255.0)


def draft_of(data: dict) -> Draft:
    """The draft of a plain dictionary. Raises InputError for unknown keys, uneven rows and values of other kinds."""
    known = ("title", "drawdown", "pile", *ARRAYS)
    if unknown := next((key for key in data if key not in known), None):
        raise InputError(one_line(f"draft: {unknown}: unknown key; known keys: {', '.join(known)}"))
    if not isinstance(data.get("pile", False), bool):
        raise InputError("draft: pile: expected true or false")
    rows = data.get("drawdown")
    good = isinstance(rows, list | tuple) and rows and all(isinstance(row, str) for row in rows)
    if not good or len({len(row) for row in rows}) != 1 or set("".join(rows)) - {UP, DOWN, CUT}:
        raise InputError(
            f'draft: drawdown: expected rows of equal length, of "{UP}" (warp on top), "{DOWN}" and "{CUT}" (cut out)'
        )
    counts = {"warp": len(rows[0]), "weft": len(rows)}
    arrays = {}
    for name in ARRAYS:
        value = data.get(name)
        if value is None:
            continue
        values = value if isinstance(value, list | tuple) else [value] * counts[name[:4]]
        colors = name.endswith("colors")
        try:
            arrays[name] = np.array([_color(v) if colors else float(v) for v in values])
        except (TypeError, ValueError):
            what = 'colours such as "#c8b496"' if colors else "lengths in cm"
            raise InputError(f"draft: {name}: expected {what}, one for each thread or one for all") from None
    signs = np.array([list(row) for row in rows])
    # What is cut out was plain weave: it binds the threads about it, and a reader sees no other.
    plain = np.indices(signs.shape).sum(0) % 2 == 0
    cut = signs == CUT
    drawdown = np.where(cut, plain, signs == UP)
    title = one_line(data.get("title", ""))
    return Draft(drawdown, **arrays, cut=cut if cut.any() else None, pile=data.get("pile", False), title=title)
