"""Colour between the renderer and the eye: luminance, the sRGB curve, and the named view transforms of 8-bit pictures.

Everything here works on linear Rec. 709 arrays [..., 3] and returns display code values in 0..1.
"""

from __future__ import annotations

import re
from collections.abc import Callable

import numpy as np

from .errors import InputError, meant

# ITU-R BT.709-6, item 3.2.
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])


def luminance(rgb: np.ndarray) -> np.ndarray:
    """Luminance [...] of linear Rec. 709 colours [..., 3]."""
    return np.asarray(rgb) @ LUMINANCE.astype(np.result_type(np.asarray(rgb).dtype, np.float32))


def srgb_encode(linear: np.ndarray) -> np.ndarray:
    """Code value 0..1 of a linear value; values outside 0..1 are clipped.   [IEC 61966-2-1]"""
    x = np.clip(linear, 0.0, 1.0)
    return np.where(x <= 0.0031308, 12.92 * x, 1.055 * np.maximum(x, 0.0031308) ** (1 / 2.4) - 0.055)


def srgb_decode(code: np.ndarray) -> np.ndarray:
    """Linear value of a code value 0..1.   [IEC 61966-2-1]"""
    x = np.asarray(code)
    return np.where(x <= 0.04045, x / 12.92, ((np.maximum(x, 0.04045) + 0.055) / 1.055) ** 2.4)


def _standard(rgb: np.ndarray) -> np.ndarray:
    """The clipped value through the sRGB curve, nothing else."""
    return srgb_encode(rgb)


def _filmic(rgb: np.ndarray) -> np.ndarray:
    """Hable 2010, "Filmic Tonemapping Operators" (the Uncharted 2 curve): white point 11.2, exposure bias 2."""

    def curve(x):
        A, B, C, D, E, F = 0.15, 0.50, 0.10, 0.20, 0.02, 0.30
        return (x * (A * x + C * B) + D * E) / (x * (A * x + B) + D * F) - E / F

    return srgb_encode(curve(2.0 * np.maximum(rgb, 0.0)) / curve(11.2))


def _neutral(rgb: np.ndarray) -> np.ndarray:
    """Khronos PBR Neutral (2024): colours up to 0.8 keep their hue and saturation, highlights run to white."""
    c = np.maximum(rgb, 0.0)
    F_90, K_s, K_d = 0.04, 0.8 - 0.04, 0.15
    x = c.min(-1, keepdims=True)
    c = c - np.where(x <= 2 * F_90, x - x * x / (4 * F_90), F_90)
    p = c.max(-1, keepdims=True)
    safe = np.maximum(p, K_s)
    p_n = 1 - (1 - K_s) ** 2 / (safe + 1 - 2 * K_s)
    g = 1 / (K_d * (safe - p_n) + 1)
    return srgb_encode(np.where(p <= K_s, c, c * (p_n / safe) * g + p_n * (1 - g)))


def _agx(rgb: np.ndarray) -> np.ndarray:
    """AgX (Sobotka 2022) in the closed form of Wrensch 2023, "Minimal AgX Implementation"; base look."""
    inset = np.array(
        [
            [0.842479062253094, 0.0784335999999992, 0.0792237451477643],
            [0.0423282422610123, 0.878468636469772, 0.0791661274605434],
            [0.0423756549057051, 0.0784336, 0.879142973793104],
        ]
    )
    outset = np.array(
        [
            [1.19687900512017, -0.0980208811401368, -0.0990297440797205],
            [-0.0528968517574562, 1.15190312990417, -0.0989611768448433],
            [-0.0529716355144438, -0.0980434501171241, 1.15107367264116],
        ]
    )
    low, high = -12.47393, 4.026069
    v = np.log2(np.maximum(np.maximum(rgb, 0.0) @ inset.T, 2.0**low))
    x = np.clip((v - low) / (high - low), 0.0, 1.0)
    # The published polynomial 15.5 x^6 - 40.14 x^5 + 31.96 x^4 - 6.868 x^3 + .4298 x^2 + .1191 x - .00232.
    s = ((((((15.5 * x - 40.14) * x + 31.96) * x - 6.868) * x + 0.4298) * x) + 0.1191) * x - 0.00232
    # The curve already yields code values of a display with exponent 2.2, so no sRGB curve follows.
    return np.clip(s @ outset.T, 0.0, 1.0)


VIEW_TRANSFORMS: dict[str, Callable[[np.ndarray], np.ndarray]] = {
    "standard": _standard,
    "filmic": _filmic,
    "neutral": _neutral,
    "agx": _agx,
}


def is_hex(text: str) -> bool:
    """Whether a text is a colour as #rgb or #rrggbb."""
    return re.fullmatch(r"#(?:[0-9a-fA-F]{3}|[0-9a-fA-F]{6})", text) is not None


def whole_hex(text: str) -> str:
    """A colour as #rrggbb, in small letters, of one as #rgb or #rrggbb."""
    digits = text.removeprefix("#").lower()
    return "#" + ("".join(2 * digit for digit in digits) if len(digits) == 3 else digits)


def hex_codes(text: str) -> tuple[float, float, float]:
    """The code values 0 to 1 of a colour as #rgb or #rrggbb. Raises ValueError."""
    if not is_hex(text):
        raise ValueError(f"expected a colour such as #ff0000, not {text}")
    digits = whole_hex(text)
    red, green, blue = (int(digits[k + 1 : k + 3], 16) / 255.0 for k in (0, 2, 4))
    return red, green, blue


def known_transform(name: str) -> str:
    """The name, if it is one of VIEW_TRANSFORMS. Raises InputError on another."""
    if name not in VIEW_TRANSFORMS:
        hint = meant(str(name), VIEW_TRANSFORMS)
        raise InputError(f"view transform {name!r}: unknown; {hint}choose one of {', '.join(VIEW_TRANSFORMS)}")
    return name


Transform = str | Callable[[np.ndarray], np.ndarray]  # a name in VIEW_TRANSFORMS, or a function such as ocio.OcioView


def view(rgb: np.ndarray, transform: Transform = "standard", exposure: float = 0.0) -> np.ndarray:
    """Code values 0..1 [..., 3] of linear Rec. 709 colours after `exposure` stops and a view transform.

    `transform` is one of VIEW_TRANSFORMS, or a function. Not-a-number becomes black, infinity white. Raises InputError on
    an unknown name.
    """
    chosen = transform if callable(transform) else VIEW_TRANSFORMS[known_transform(transform)]
    # 2^15 is beyond every curve's shoulder; larger finite values would overflow in the rational curves.
    scaled = np.nan_to_num(np.asarray(rgb, np.float64), nan=0.0, posinf=1e30, neginf=0.0) * 2.0**exposure
    return chosen(np.clip(scaled, 0.0, 2.0**15))
