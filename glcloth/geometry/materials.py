"""The base-colour pictures of objects' materials."""

from __future__ import annotations

import numpy as np

from ..color import srgb_decode
from ..errors import InputError
from ..formats.common import TooLargeError
from ..image import decode_codes
from ..progress import warn
from .raw import Material


def base_picture(material: Material, where: str = "") -> np.ndarray | None:
    """The base colours [H, W, 3 or 4] of a material's picture, sRGB codes in 0 to 1; None without one, or with a warning
    where it cannot be decoded. Raises InputError for one that is too large, naming the file `where`."""
    if material.texture is None:
        return None
    try:
        return decode_codes(material.texture)
    except InputError as error:
        called = f"{where}: material {material.name or '(unnamed)'}"
        if isinstance(error, TooLargeError):
            raise InputError(f"{called}: {error}") from None
        warn(f"{called}: its picture is left out: {error}")
        return None


def mean_color(material: Material, where: str = "") -> tuple[float, float, float]:
    """The linear colour [3] of a material, its picture by its mean. Raises as `base_picture`."""
    codes = base_picture(material, where)
    if codes is None:
        return material.color
    r, g, b = (np.array(material.color) * srgb_decode(codes[..., :3].astype(float)).mean((0, 1))).tolist()
    return r, g, b


COARSE = 64  # texels a side: of a picture that says what triangles reflect on the whole


def colors_at(material: Material, uv: np.ndarray, where: str = "") -> np.ndarray | None:
    """The linear colours [N, 3] of triangles with UVs [N, 3, 2], coarsely, for the light they send on; None without a picture.
    Raises as `base_picture`."""
    codes = base_picture(material, where)
    if codes is None:
        return None
    picture = srgb_decode(codes[::-1, :, :3].astype(float))
    steps = [max(1, side // COARSE) for side in picture.shape[:2]]
    rows, columns = (side // step for side, step in zip(picture.shape[:2], steps, strict=True))
    picture = picture[: rows * steps[0], : columns * steps[1]]
    coarse = picture.reshape(rows, steps[0], columns, steps[1], 3).mean((1, 3))
    middle = np.nan_to_num(uv).mean(1) % 1.0
    at = (middle[:, ::-1] * (rows, columns)).astype(int) % (rows, columns)
    return np.array(material.color) * coarse[at[:, 0], at[:, 1]]
