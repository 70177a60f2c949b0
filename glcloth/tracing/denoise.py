"""What noise path tracing leaves, taken away by Intel Open Image Denoise, which pyoidn brings.   [Afra 2025, oidn]"""

from __future__ import annotations

import importlib.util

import numpy as np

from ..errors import InputError
from .path import PathSums


def check_denoiser() -> None:
    """Raise InputError where pyoidn is not installed."""
    if importlib.util.find_spec("pyoidn") is None:
        raise InputError("--denoise: needs Open Image Denoise: pip install 'glcloth[denoise]'; or leave it out")


def denoised(sums: PathSums) -> np.ndarray:
    """The picture without its noise: float32 [H, W, 4], linear Rec. 709, alpha premultiplied, top row first.

    Normals and albedos of what is seen first tell edges and patterns from noise. Raises InputError where pyoidn is not
    installed, or does not work on this machine.
    """
    check_denoiser()
    picture, n = sums.picture, float(sums.samples)
    cover = np.clip(picture[..., 3:], 0.0, 1.0)
    # Where the environment is seen its light takes the place of an albedo of 1.
    albedo = np.clip(sums.albedo / n + (1.0 - cover), 0.0, 1.0).astype(np.float32)
    normal = np.clip(sums.normal / n, -1.0, 1.0).astype(np.float32)
    partly = bool(((cover > 0.0) & (cover < 1.0)).any())
    try:
        import pyoidn

        light = pyoidn.denoise(np.maximum(picture[..., :3], 0.0), albedo, normal, hdr=True)
        alpha = pyoidn.denoise(np.repeat(cover, 3, -1), albedo, normal)[..., :1] if partly else cover
    except (ImportError, OSError, RuntimeError) as error:
        raise InputError(f"--denoise: Open Image Denoise fails on this machine ({error}); leave it out") from None
    return np.concatenate([light, alpha], -1)
