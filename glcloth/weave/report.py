"""What a weaver asks of a cloth: sett, repeat, floats, cover and the angles of the yarns, as plain values and as text."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .floats import float_lengths
from .model import Weave

SYSTEMS = ("warp", "weft")


def weave_report(weave: Weave, yarns: Sequence) -> dict:
    """Facts of a weave for JSON; `yarns` are the fabric's two, which know their area and their tangents.

    sett: threads a cm. repeat, structure: [picks, ends]. floats: for each system the longest, the mean, and how many of
    each length on the face of one repeat. width_cm, height_cm: of the yarns. largest_tilt_deg: of their axes. area: share of
    the cloth where they lie on top; gap: the rest. tangents_deg: those of the far field, with their shares (None where equal).
    """
    draft, shape = weave.drafted, weave.shape
    picks, ends = draft.structure
    floats = {s: _counts(n) for s, n in zip(SYSTEMS, float_lengths(draft.drawdown[:picks, :ends]), strict=True)}
    colors = weave.thread_colors
    of_colors = (len(colors[1]), len(colors[0])) if colors else (1, 1)
    widths = [w * p for w, p in zip(shape.width, shape.pitch, strict=True)]
    return {
        "title": draft.title,
        "sett": dict(zip(SYSTEMS, (weave.ends_per_cm, weave.picks_per_cm), strict=True)),
        "structure": [picks, ends],
        "repeat": [int(np.lcm(a, b)) for a, b in zip((picks, ends), of_colors, strict=True)],
        "floats": floats,
        "width_cm": dict(zip(SYSTEMS, widths, strict=True)),
        "height_cm": dict(zip(SYSTEMS, shape.heights, strict=True)),
        "largest_tilt_deg": dict(zip(SYSTEMS, np.degrees(shape.largest_tilts).tolist(), strict=True)),
        "area": dict(zip(SYSTEMS, (yarn.area for yarn in yarns), strict=True)),
        "gap": max(0.0, 1.0 - sum(yarn.area for yarn in yarns)),
        "tangents_deg": dict(zip(SYSTEMS, (yarn.tilts_deg for yarn in yarns), strict=True)),
        "shares": dict(zip(SYSTEMS, (yarn.tilt_shares for yarn in yarns), strict=True)),
        "warnings": list(draft.warnings),
    }


def lines_of(facts: dict) -> list[str]:
    """A report as lines of text for people."""
    sett, floats, area = facts["sett"], facts["floats"], facts["area"]
    picks, ends = facts["repeat"]
    structure = f", of the structure alone {facts['structure'][1]} x {facts['structure'][0]}"
    lines = [
        f"sett     {sett['warp']:.4g} ends x {sett['weft']:.4g} picks a cm",
        f"repeat   {ends} ends x {picks} picks" + (structure if facts["structure"] != facts["repeat"] else ""),
        *(f"{s}     {_floats_line(floats[s])}" for s in SYSTEMS),
        f"yarns    {_pair(facts['width_cm'], 10, '.3g')} mm wide, {_pair(facts['height_cm'], 10, '.3g')} mm high",
        f"tilt     up to {_pair(facts['largest_tilt_deg'], 1, '.1f')} degrees (warp, weft)",
        f"cover    warp {area['warp']:.1%}, weft {area['weft']:.1%}, holes {facts['gap']:.1%}",
        f"far      {len(facts['tangents_deg']['warp'])} + {len(facts['tangents_deg']['weft'])} tangents",
    ]
    return lines + [f"note     {warning}" for warning in facts["warnings"]]


def _counts(lengths: np.ndarray) -> dict:
    if not lengths.size:
        return {"longest": 0, "mean": 0.0, "counts": {}}
    values, counts = np.unique(lengths, return_counts=True)
    by_length = {str(int(v)): int(c) for v, c in zip(values, counts, strict=True)}
    return {"longest": int(lengths[-1]), "mean": float(lengths.mean()), "counts": by_length}


def _floats_line(floats: dict) -> str:
    if not floats["longest"]:
        return "never on the face"
    counts = sorted(floats["counts"].items(), key=lambda item: -item[1])[:4]
    most = ", ".join(f"{count} over {length}" for length, count in counts)
    return f"floats up to {floats['longest']}, mean {floats['mean']:.2f} ({most})"


def _pair(values: dict, factor: float, form: str) -> str:
    return " and ".join(f"{factor * values[s]:{form}}" for s in SYSTEMS)
