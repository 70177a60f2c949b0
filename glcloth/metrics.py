"""How far two pictures are apart: FLIP, RMSE, relMSE, PSNR, and pictures of the difference."""

from __future__ import annotations

import flip_evaluator
import numpy as np

from .color import srgb_encode
from .errors import InputError


def check_alike(a: np.ndarray, b: np.ndarray, where: str) -> None:
    """Raise InputError unless two pictures have the same size."""
    if a.shape[:2] != b.shape[:2]:
        sizes = " and ".join(f"{p.shape[1]}x{p.shape[0]}" for p in (a, b))
        raise InputError(f"{where}: sizes {sizes} differ; compare pictures of one size")


def rmse(test: np.ndarray, reference: np.ndarray) -> float:
    """Root mean square difference of linear values, over pixels and channels."""
    return float(np.sqrt(np.mean((np.float64(test) - reference) ** 2)))


def relmse(test: np.ndarray, reference: np.ndarray) -> float:
    """Mean of (difference / reference)^2, with 0.01 added to the squared reference (Rousselle et al. 2011)."""
    return float(np.mean((np.float64(test) - reference) ** 2 / (np.float64(reference) ** 2 + 0.01)))


def psnr(test: np.ndarray, reference: np.ndarray) -> float:
    """Peak signal-to-noise ratio in dB; the peak is the reference's largest value. Infinite for equal pictures."""
    error = rmse(test, reference)
    peak = max(float(np.max(reference)), 1e-12)
    return float("inf") if error == 0 else float(20 * np.log10(peak / error))


def flip_map(test: np.ndarray, reference: np.ndarray) -> np.ndarray:
    """LDR-FLIP per pixel [H, W] in 0..1 of linear pictures as a display shows them (Andersson et al. 2020)."""
    shown = [np.ascontiguousarray(srgb_encode(p[..., :3]), np.float32) for p in (reference, test)]
    values, _, _ = flip_evaluator.evaluate(*shown, "LDR", inputsRGB=True, applyMagma=False)
    return np.asarray(values)[..., 0] if np.ndim(values) == 3 else np.asarray(values)


def flip(test: np.ndarray, reference: np.ndarray) -> float:
    """Mean LDR-FLIP, 0 (equal) to 1."""
    return float(flip_map(test, reference).mean())


METRICS = {"flip": flip, "rmse": rmse, "relmse": relmse, "psnr": psnr}


BETTER_ABOVE = {"psnr"}


def compare(
    test: np.ndarray, reference: np.ndarray, metrics=tuple(METRICS), where: np.ndarray | None = None
) -> dict[str, float]:
    """Metrics of a test picture against a reference, linear [H, W, 3], by their names: flip, rmse, relmse, psnr.

    where : bool [H, W], the pixels that count, such as those of the cloth: a background that is equal in both would dilute
        all means.

    Raises InputError when the sizes differ, and where no pixel counts.
    """
    check_alike(test, reference, "compare")
    test, reference = np.asarray(test)[..., :3], np.asarray(reference)[..., :3]
    if where is None:
        return {name: METRICS[name](test, reference) for name in metrics}
    check_alike(where, reference, "compare, where")
    if not where.any():
        raise InputError("compare: no pixel counts; expected a mask that is not black")
    values = {name: METRICS[name](test[where], reference[where]) for name in metrics if name != "flip"}
    if "flip" in metrics:  # which looks at neighbours
        values["flip"] = float(flip_map(test, reference)[where].mean())
    return {name: values[name] for name in metrics}


def difference(test: np.ndarray, reference: np.ndarray, scale: float = 8.0) -> np.ndarray:
    """|test - reference| x scale, linear [H, W, 3], as figures 4-6 of paper A show it."""
    return np.abs(np.float32(test[..., :3]) - reference[..., :3]) * np.float32(scale)
