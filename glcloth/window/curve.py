"""Edits of a tangent curve, as the plot makes them: pure functions of a Yarn that return fields to change."""

from __future__ import annotations

import numpy as np

from ..fabric import Yarn

STEP_DEG, STEP_LENGTH = 0.1, 0.01  # a hand's precision: files stay readable


def points(yarn: Yarn) -> tuple[np.ndarray, np.ndarray]:
    """Positions along the yarn and angles of the handles: the curve's control points, or the tangents."""
    if yarn.tangents_deg is not None:
        return np.arange(len(yarn.tangents_deg), dtype=float), np.array(yarn.tangents_deg)
    return np.concatenate([[0.0], np.cumsum(yarn.curve_lengths)]), np.array(yarn.curve_angles_deg)


def samples(yarn: Yarn) -> tuple[np.ndarray, np.ndarray]:
    """Positions and angles of the sampled tangents."""
    tilts = np.array(yarn.tilts_deg)
    if yarn.tangents_deg is not None:
        return np.arange(len(tilts), dtype=float), tilts
    end = float(sum(yarn.curve_lengths))
    return (np.linspace(0.0, end, len(tilts)) if len(tilts) > 1 else np.array([end / 2])), tilts


def move(yarn: Yarn, index: int, at: float, angle: float) -> dict:
    """Drag a point: its angle, and (of a curve) the lengths before and after it, which keep their sum."""
    angle = float(np.clip(round(angle / STEP_DEG) * STEP_DEG, -90.0, 90.0))
    angle = round(angle, 6)
    if yarn.tangents_deg is not None:
        return {"tangents_deg": _with(yarn.tangents_deg, index, angle)}
    changes = {"curve_angles_deg": _with(yarn.curve_angles_deg, index, angle)}
    lengths = list(yarn.curve_lengths)
    place, _ = points(yarn)
    if 0 < index < len(place) - 1:
        before = float(np.clip(at - place[index - 1], 0.0, lengths[index - 1] + lengths[index]))
        before = round(before, 2)
        lengths[index - 1], lengths[index] = before, round(max(place[index + 1] - place[index - 1] - before, 0.0), 6)
    elif index > 0:
        lengths[-1] = round(max(at - place[-2], 0.0), 2)
        if sum(lengths) < STEP_LENGTH:
            lengths[-1] = STEP_LENGTH
    changes["curve_lengths"] = tuple(lengths)
    return changes


def set_length(yarn: Yarn, index: int, length: float) -> dict:
    """Change one length; the others stay."""
    lengths = _with(yarn.curve_lengths, index, round(max(float(length), 0.0), 4))
    if sum(lengths) < STEP_LENGTH:
        lengths = _with(lengths, index, STEP_LENGTH)
    return {"curve_lengths": lengths}


def add(yarn: Yarn) -> dict:
    """One more point: in the middle of the longest segment, or one more tangent at the end."""
    if yarn.tangents_deg is not None:
        return {"tangents_deg": (*yarn.tangents_deg, yarn.tangents_deg[-1])}
    lengths, angles = list(yarn.curve_lengths), list(yarn.curve_angles_deg)
    i = int(np.argmax(lengths))
    angles.insert(i + 1, round((angles[i] + angles[i + 1]) / 2, 6))
    lengths[i : i + 1] = [lengths[i] / 2, lengths[i] / 2]
    return {"curve_angles_deg": tuple(angles), "curve_lengths": tuple(lengths)}


def remove(yarn: Yarn) -> dict:
    """One point less (the last but one of a curve, whose segments become one); nothing when only the ends are left."""
    if yarn.tangents_deg is not None:
        return {"tangents_deg": yarn.tangents_deg[:-1]} if len(yarn.tangents_deg) > 1 else {}
    lengths, angles = list(yarn.curve_lengths), list(yarn.curve_angles_deg)
    if len(angles) <= 2:
        return {}
    del angles[-2]
    lengths[-2:] = [lengths[-2] + lengths[-1]]
    return {"curve_angles_deg": tuple(angles), "curve_lengths": tuple(lengths)}


def to_curve(yarn: Yarn) -> dict:
    """The curve whose samples are these tangents."""
    tilts = yarn.tangents_deg if len(yarn.tangents_deg) > 1 else yarn.tangents_deg * 2
    return {
        "tangents_deg": None,
        "curve_angles_deg": tilts,
        "curve_lengths": (1.0,) * (len(tilts) - 1),
        "samples": len(yarn.tangents_deg),
    }


def _with(values: tuple, index: int, value: float) -> tuple:
    return (*values[:index], value, *values[index + 1 :])
