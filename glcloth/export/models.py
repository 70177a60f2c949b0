"""What other renderers offer for cloth, in float64: glTF 2.0's material with its extensions, OpenPBR's surface, and the
principled BRDF that U3M names.

Each is one elongated GGX lobe over a diffuse base, but OpenPBR's with a sheen on top. Fits find the parameters whose response is
nearest to a fabric's.   [Khronos 2021, glTF 2.0 appendix B, KHR_materials_specular, anisotropy and sheen; ASWF 2024, OpenPBR 1.1]
"""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from ..color import luminance
from ..fabric import Fabric
from .original import Response, hemisphere, response

PAIRS = 3000
GLTF = ("base_r", "base_g", "base_b", "specular_r", "specular_g", "specular_b", "roughness", "stretch",
        "sheen_r", "sheen_g", "sheen_b", "sheen_roughness")  # fmt: skip
PRINCIPLED = ("base_r", "base_g", "base_b", "specular", "specular_tint", "roughness", "stretch", "sheen", "sheen_tint")
OPENPBR = ("base_r", "base_g", "base_b", "specular_r", "specular_g", "specular_b", "roughness", "stretch", "ior")


@dataclass(frozen=True)
class Fitted:
    """A model's parameters by name, which way its lobe is stretched, and its response.

    across : the lobe is widest along yarn 2, as it is where yarn 1 shines.
    """

    values: dict[str, float]
    across: bool
    model: Response

    def color(self, name: str) -> tuple[float, float, float]:
        """Three values as one colour."""
        r, g, b = (self.values[f"{name}_{c}"] for c in "rgb")
        return r, g, b


def fit_gltf(fabric: Fabric) -> Fitted:
    """The glTF material nearest to a fabric."""
    first = [0.3, 0.3, 0.3, 1.0, 1.0, 1.0, 0.5, 0.5, 0.1, 0.1, 0.1, 0.5]
    low = [0.0] * 6 + [0.1, 0.0] + [0.0] * 3 + [0.15]
    high = [1.0] * 3 + [25.0] * 3 + [1.0, 0.99] + [1.0] * 4
    return _fit(fabric, gltf, GLTF, first, low, high)


def fit_openpbr(fabric: Fabric) -> Fitted:
    """The OpenPBR surface nearest to a fabric."""
    first = [0.3, 0.3, 0.3, 0.9, 0.9, 0.9, 0.5, 0.5, 1.5]
    low, high = [0.0] * 6 + [0.1, 0.0, 1.01], [1.0] * 7 + [0.98, 3.0]
    return _fit(fabric, openpbr, OPENPBR, first, low, high)


def fit_principled(fabric: Fabric) -> Fitted:
    """The principled material nearest to a fabric."""
    first = [0.3, 0.3, 0.3, 0.5, 0.5, 0.5, 0.5, 0.1, 0.5]
    low, high = [0.0] * 5 + [0.1] + [0.0] * 3, [1.0] * 9
    return _fit(fabric, principled, PRINCIPLED, first, low, high)


def _fit(fabric: Fabric, model: Callable, names: tuple[str, ...], first: list, low: list, high: list) -> Fitted:
    """Least squares over pairs of directions, of differences over the root of what is there: neither highlights nor the
    dark alone decide."""
    i, o = hemisphere(PAIRS, 1), hemisphere(PAIRS, 2)
    truth = response(fabric)(i, o)
    weight = 1.0 / np.sqrt(truth + truth.mean())
    best = None
    for across, roughness in itertools.product((True, False), (0.25, 0.6)):
        a, b = _turned(i, across), _turned(o, across)
        begin = [roughness if name == "roughness" else value for name, value in zip(names, first, strict=True)]
        found = least_squares(
            lambda p, a=a, b=b: (weight * (model(p, a, b) - truth)).ravel(),
            begin, bounds=(low, high), x_scale=high, ftol=1e-4, max_nfev=40,
        )  # fmt: skip
        if best is None or found.cost < best[0]:
            best = found.cost, found.x, across
    assert best is not None
    _, p, across = best
    values = dict(zip(names, map(float, p), strict=True))
    return Fitted(values, across, lambda i, o: model(p, _turned(i, across), _turned(o, across)))


def _turned(omega: np.ndarray, across: bool) -> np.ndarray:
    """Directions in a frame whose x is the way the lobe is stretched."""
    return np.stack([omega[..., 1], -omega[..., 0], omega[..., 2]], -1) if across else omega


def gltf(p: np.ndarray, omega_i: np.ndarray, omega_o: np.ndarray) -> np.ndarray:
    """glTF's response f cos(theta_i) [..., 3]; p as GLTF names it, x the way of the anisotropy's direction."""
    base, color, sheen = p[0:3], p[3:6], p[8:11]
    a_b = p[6] ** 2
    a_t = a_b + (1.0 - a_b) * p[7] ** 2
    l, v = np.maximum(omega_i[..., 2], 0.0), np.maximum(omega_o[..., 2], 1e-4)
    f_0 = np.minimum(0.04 * color, 1.0)
    lobe, v_h = _ggx(omega_i, omega_o, a_t, a_b)
    F = f_0 + (1.0 - f_0) * (1.0 - v_h[..., None]) ** 5
    value = (1.0 - F.max(-1, keepdims=True)) * base / np.pi + F * lobe[..., None]
    alpha = p[11] ** 2
    scale = 1.0 - sheen.max() * np.interp(v, *_sheen_albedo(alpha))
    value = sheen * _sheen(omega_i, omega_o, alpha)[..., None] + scale[..., None] * value
    return np.where((omega_i[..., 2] > 0.0)[..., None], value * l[..., None], 0.0)


def openpbr(p: np.ndarray, omega_i: np.ndarray, omega_o: np.ndarray) -> np.ndarray:
    """OpenPBR's response f cos(theta_i) [..., 3] without fuzz, coat and metal; p as OPENPBR names it, x its tangent."""
    base, color, ior = p[0:3], p[3:6], p[8]
    a_t = p[6] ** 2 * np.sqrt(2.0 / (1.0 + (1.0 - p[7]) ** 2))
    a_b = (1.0 - p[7]) * a_t
    l, v = np.maximum(omega_i[..., 2], 0.0), np.maximum(omega_o[..., 2], 1e-4)
    lobe, v_h = _ggx(omega_i, omega_o, a_t, max(a_b, 1e-4))
    F = _dielectric(v_h, ior)[..., None]
    E = _ggx_albedo(v, np.sqrt(a_t * max(a_b, 1e-4)), ((ior - 1.0) / (ior + 1.0)) ** 2)
    value = color * F * lobe[..., None] + (1.0 - color.max() * E[..., None]) * base / np.pi
    return np.where((omega_i[..., 2] > 0.0)[..., None], value * l[..., None], 0.0)


def principled(p: np.ndarray, omega_i: np.ndarray, omega_o: np.ndarray) -> np.ndarray:
    """The principled BRDF's response f cos(theta_i) [..., 3] without metal and coat; p as PRINCIPLED names it, x its
    tangent. Masking is height-correlated.   [Burley 2012]"""
    base, rough = p[0:3], p[5]
    aspect = np.sqrt(1.0 - 0.9 * p[6])
    l, v = np.maximum(omega_i[..., 2], 0.0), np.maximum(omega_o[..., 2], 0.0)
    lobe, v_h = _ggx(omega_i, omega_o, max(rough**2 / aspect, 1e-3), max(rough**2 * aspect, 1e-3))
    tint = base / max(luminance(base), 1e-6)
    f_0 = 0.08 * p[3] * (1.0 + p[4] * (tint - 1.0))
    grazing = (1.0 - v_h) ** 5
    F = f_0 + (1.0 - f_0) * grazing[..., None]
    f_90 = 0.5 + 2.0 * v_h**2 * rough
    retro = (1.0 + (f_90 - 1.0) * (1.0 - l) ** 5) * (1.0 + (f_90 - 1.0) * (1.0 - v) ** 5)
    sheen = p[7] * (1.0 + p[8] * (tint - 1.0)) * grazing[..., None]
    value = base / np.pi * retro[..., None] + sheen + F * lobe[..., None]
    return np.where((omega_i[..., 2] > 0.0)[..., None], value * l[..., None], 0.0)


def _ggx(omega_i, omega_o, a_t: float, a_b: float) -> tuple[np.ndarray, np.ndarray]:
    """(D V, cosine between view and half vector) of an elongated GGX lobe, height-correlated."""
    h = omega_i + omega_o
    h = h / np.maximum(np.linalg.norm(h, axis=-1, keepdims=True), 1e-9)
    stretch = np.array([1.0 / a_t, 1.0 / a_b, 1.0])
    D = 1.0 / (np.pi * a_t * a_b * (((h * stretch) ** 2).sum(-1)) ** 2)
    length_i, length_o = (np.linalg.norm(w * [a_t, a_b, 1.0], axis=-1) for w in (omega_i, omega_o))
    l, v = np.maximum(omega_i[..., 2], 1e-6), np.maximum(omega_o[..., 2], 1e-6)
    return D * 0.5 / (l * length_o + v * length_i), np.clip((omega_o * h).sum(-1), 0.0, 1.0)


def _dielectric(c: np.ndarray, ior: float) -> np.ndarray:
    """Fresnel's reflectance of unpolarised light."""
    t = np.sqrt(np.maximum(1.0 - (1.0 - c * c) / ior**2, 0.0))
    r_s, r_p = (c - ior * t) / (c + ior * t), (ior * c - t) / (ior * c + t)
    return 0.5 * (r_s**2 + r_p**2)


def _ggx_albedo(x: np.ndarray, y: float, f_0: float) -> np.ndarray:
    """Directional albedo of a GGX lobe of roughness y at cosine x, MaterialX's rational fit."""
    r = [
        [0.1003, 0.9345, 1.0, 1.0], [-0.6303, -2.323, -1.765, 0.2281], [9.748, 2.229, 8.263, 15.94],
        [-2.038, -3.748, 11.53, -55.83], [29.34, 1.424, 28.96, 13.08], [-8.245, -0.7684, -7.507, 41.26],
        [-26.44, 1.436, -36.11, 54.9], [19.99, 0.2913, 15.86, 300.2], [-5.448, 0.6286, 33.37, -285.1],
    ]  # fmt: skip
    powers = [np.ones_like(x), x, y + 0 * x, x * y, x**2, y**2 + 0 * x, x**2 * y, x * y**2, x**2 * y**2]
    a, b, c, d = np.tensordot(np.array(r).T, np.array(powers), 1)
    return np.clip(f_0 * np.clip(a / c, 0.0, 1.0) + np.clip(b / d, 0.0, 1.0), 0.0, 1.0)


def _sheen(omega_i, omega_o, alpha: float) -> np.ndarray:
    """Charlie's distribution with the visibility of Neubelt and Pettineo, as KHR_materials_sheen has them."""
    h = omega_i + omega_o
    z = h[..., 2] / np.maximum(np.linalg.norm(h, axis=-1), 1e-9)
    D = (2.0 + 1.0 / alpha) * np.maximum(1.0 - z * z, 1e-7) ** (0.5 / alpha) / (2.0 * np.pi)
    l, v = np.maximum(omega_i[..., 2], 1e-6), np.maximum(omega_o[..., 2], 1e-6)
    return D / (4.0 * (l + v - l * v))


def _sheen_albedo(alpha: float) -> tuple[np.ndarray, np.ndarray]:
    """(cosines of the view, albedo of a white sheen there)."""
    z, phi = (np.arange(24) + 0.5) / 24, np.pi * (np.arange(24) + 0.5) / 24
    r = np.sqrt(1.0 - z * z)
    i = np.stack([r[:, None] * np.cos(phi), r[:, None] * np.sin(phi), np.broadcast_to(z[:, None], (24, 24))], -1)
    c = np.linspace(0.02, 1.0, 16)
    o = np.stack([np.sqrt(1.0 - c * c), 0 * c, c], -1)[:, None, None]
    return c, (_sheen(i, o, alpha) * i[..., 2]).mean((1, 2)) * 2.0 * np.pi
