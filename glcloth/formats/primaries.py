"""Colours of other primaries as linear Rec. 709."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

REC_709 = (0.64, 0.33, 0.30, 0.60, 0.15, 0.06, 0.3127, 0.3290)  # x, y of red, green, blue and white
SAME = 2e-3  # chromaticities that differ by less are the same: files round them
# Lam 1985; Lindbloom, "Chromatic Adaptation".
BRADFORD = np.array([[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]])


def xyz_of(x: float, y: float) -> np.ndarray:
    """XYZ [3] of a chromaticity, Y = 1."""
    return np.array([x / y, 1.0, (1.0 - x - y) / y])


def xyz_from_rgb(primaries: Sequence[float]) -> np.ndarray:
    """The matrix [3, 3] to XYZ, white's Y = 1.   [SMPTE RP 177]"""
    columns = np.stack([xyz_of(*primaries[2 * k : 2 * k + 2]) for k in range(3)], 1)
    return columns * np.linalg.solve(columns, xyz_of(*primaries[6:8]))


def adapted(white: np.ndarray) -> np.ndarray:
    """The matrix [3, 3] that takes XYZ under a white [3] to XYZ under D65, Bradford."""
    gain = (BRADFORD @ xyz_of(*REC_709[6:])) / (BRADFORD @ white)
    return np.linalg.inv(BRADFORD) @ (gain[:, None] * BRADFORD)


def rec709_from_xyz(white: Sequence[float]) -> np.ndarray:
    """The matrix [3, 3] from XYZ, under a white of this chromaticity, which becomes that of Rec. 709."""
    return np.linalg.inv(xyz_from_rgb(REC_709)) @ adapted(xyz_of(*white))


def rec709_from(primaries: Sequence[float]) -> np.ndarray | None:
    """The matrix [3, 3] from RGB of these primaries and white (x, y of red, green, blue, white), whose white becomes that
    of Rec. 709; None where they are those of Rec. 709, or no colours at all."""
    values = np.asarray(primaries, float)
    if values.shape != (8,) or not np.isfinite(values).all() or np.abs(values - REC_709).max() < SAME:
        return None
    if (np.abs(values[1::2]) < 1e-6).any():
        return None
    with np.errstate(all="ignore"):
        try:
            matrix = rec709_from_xyz(values[6:]) @ xyz_from_rgb(values)
        except np.linalg.LinAlgError:
            return None
    return matrix if np.isfinite(matrix).all() and np.abs(matrix).max() < 1e3 else None


def converted(pixels: np.ndarray, matrix: np.ndarray) -> np.ndarray:
    """Pixels [H, W, 3 or 4] with their colours times a matrix, float32; rows at a time, to spare memory."""
    out = np.array(pixels, np.float32)
    with np.errstate(invalid="ignore", over="ignore"):
        for y in range(0, len(out), 256):
            out[y : y + 256, :, :3] = out[y : y + 256, :, :3].astype(np.float64) @ matrix.T
    return out
