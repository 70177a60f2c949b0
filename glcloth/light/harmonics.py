"""Real spherical harmonics: values, gradients, the transform of a map, and the coefficients of Gaussians and suns.

The pole is +y; the azimuth is phi = 2 pi u of equirect.py (from -z toward +x). Coefficients [(l_max + 1)^2] are in the
usual order l (l + 1) + m; m > 0 goes with cos(m phi), m < 0 with sin(|m| phi); no Condon-Shortley phase. The functions
are orthonormal over the sphere.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from . import equirect

L_MAX = 32


@dataclass(frozen=True)
class _Tables:
    """Tables of one l_max. J = (l_max + 1)^2."""

    l: np.ndarray  # [J] degree
    m: np.ndarray  # [J] |order|
    trig: np.ndarray  # [J] index into the stack cos(0 phi) .. cos(L phi), sin(1 phi) .. sin(L phi)
    a: np.ndarray  # [L + 1, L + 1] recurrence factors
    b: np.ndarray
    start: np.ndarray  # [L + 1] value of the (m, m) polynomial
    slope: np.ndarray  # [J] factor that takes the (l, m + 1) polynomial to the derivative of the (l, m) one


@lru_cache(maxsize=8)
def _tables(l_max: int) -> _Tables:
    l = np.repeat(np.arange(l_max + 1), 2 * np.arange(l_max + 1) + 1)
    signed = np.concatenate([np.arange(-k, k + 1) for k in range(l_max + 1)])
    m = np.abs(signed)
    trig = np.where(signed >= 0, m, l_max + m)
    degree, order = np.mgrid[0 : l_max + 1, 0 : l_max + 1].astype(float)
    with np.errstate(divide="ignore", invalid="ignore"):
        a = np.sqrt((4 * degree**2 - 1) / (degree**2 - order**2))
        b = np.sqrt(((degree - 1) ** 2 - order**2) / (4 * (degree - 1) ** 2 - 1))
    start = np.sqrt(1 / (4 * np.pi)) * np.ones(l_max + 1)
    for k in range(1, l_max + 1):
        start[k] = start[k - 1] * np.sqrt((2 * k + 1) / (2 * k) * (2 if k == 1 else 1))
    slope = np.sqrt((l + m + 1.0) * (l - m)) / np.where(m == 0, np.sqrt(2.0), 1.0)
    return _Tables(l, m, trig, np.nan_to_num(a, posinf=0), np.nan_to_num(b), start, slope)


def _polynomials(z: np.ndarray, l_max: int) -> np.ndarray:
    """N_lm d^m P_l / dz^m at z [N]: [l_max + 1, l_max + 2, N], 0 where m > l.

    Without the factor sin^m(theta) these are polynomials, so gradients need no division at the poles. The recurrence
    in l at fixed m is the stable direction.
    """
    t = _tables(l_max)
    P = np.zeros((l_max + 1, l_max + 2, len(z)))
    P[0, 0] = t.start[0]
    for l in range(1, l_max + 1):
        P[l, l] = t.start[l]
        np.multiply(P[l - 1, :l], z, out=P[l, :l])
        if l > 1:
            P[l, : l - 1] -= t.b[l, : l - 1, None] * P[l - 2, : l - 1]
        P[l, :l] *= t.a[l, :l, None]
    return P


def _powers(x: np.ndarray, y: np.ndarray, l_max: int) -> np.ndarray:
    """Real and imaginary parts of (x + i y)^m: [2 l_max + 1, N], real m = 0.., then imaginary m = 1.. ."""
    w = np.empty((l_max + 1, len(x)), complex)
    w[0] = 1
    w[1:] = x + 1j * y
    np.multiply.accumulate(w, axis=0, out=w)
    return np.concatenate([w.real, w.imag[1:]])


def harmonics(omega: np.ndarray, l_max: int = L_MAX) -> np.ndarray:
    """Values [N, (l_max + 1)^2] of the real spherical harmonics at unit directions omega [N, 3]."""
    return Evaluation(np.asarray(omega, float), l_max).Y.T


class Evaluation:
    """Harmonics at N directions, kept so that gradients can be contracted without forming them."""

    def __init__(self, omega: np.ndarray, l_max: int):
        self.t = _tables(l_max)
        self.l_max = l_max
        self.P = _polynomials(omega[:, 1], l_max)
        self.CS = _powers(-omega[:, 2], omega[:, 0], l_max)
        self.T = self.P[self.t.l, self.t.m]
        self.trig = self.CS[self.t.trig]
        self.Y = self.T * self.trig  # [J, N]

    def gradient(self, G: np.ndarray) -> np.ndarray:
        """Sum over j of G [J, N] times the gradient of Y_j in omega (of its polynomial extension): [N, 3]."""
        t, L = self.t, self.l_max
        dz = np.einsum("jn,jn->n", G * self.trig, self.P[t.l, t.m + 1] * t.slope[:, None])
        # d(x + i y)^m = m (x + i y)^(m - 1) (dx + i dy)
        m = np.arange(L + 1)[:, None]
        C, S = self.CS[: L + 1], np.concatenate([np.zeros_like(self.CS[:1]), self.CS[L + 1 :]])
        C_below, S_below = np.roll(C, 1, axis=0) * m, np.roll(S, 1, axis=0) * m
        by_x = np.concatenate([C_below, S_below[1:]])
        by_y = np.concatenate([-S_below, C_below[1:]])
        GT = G * self.T
        dx = np.einsum("jn,jn->n", GT, by_x[t.trig])
        dy = np.einsum("jn,jn->n", GT, by_y[t.trig])
        return np.stack([dy, dz, -dx], -1)


@lru_cache(maxsize=2)
def _row_polynomials(height: int, l_max: int) -> np.ndarray:
    theta = (np.arange(height) + 0.5) / height * np.pi
    P = _polynomials(np.cos(theta), l_max)[:, : l_max + 1]
    return P * np.sin(theta) ** np.arange(l_max + 1)[None, :, None]


def transform(radiance: np.ndarray, l_max: int = L_MAX, rows: int = 256) -> np.ndarray:
    """Coefficients [(l_max + 1)^2, C] of an equirectangular map [H, W, C], float64.

    The map is first averaged over (or repeated on) a grid of about `rows` x 2 `rows` texels; each texel then counts
    with its exact solid angle at its centre, which is right to (l pi / rows)^2 / 24.
    """
    height, width = radiance.shape[:2]
    if height > rows or width > 2 * rows:
        radiance = equirect.downsample(radiance, min(height, rows), min(width, 2 * rows))
        height, width = radiance.shape[:2]
    values = np.repeat(np.asarray(radiance, float), max(rows // height, 1), axis=0)
    values = np.repeat(values, max(2 * rows // width, 1), axis=1)
    height, width, channels = values.shape
    t = _tables(l_max)
    m = np.arange(l_max + 1)
    F = np.fft.fft(values, axis=1)[:, m % width]
    F *= np.exp(-1j * np.pi * m / width)[None, :, None] * equirect.row_solid_angles(height, width)[:, None, None]
    P = _row_polynomials(height, l_max)
    per_order = np.einsum("lmh,hmc->lmc", P, F) if l_max < 4 else np.stack([P[:, k] @ F[:, k] for k in m], 1)
    picked = per_order[t.l, t.m]
    return np.where((t.trig > l_max)[:, None], -picked.imag, picked.real).reshape(len(t.l), channels)


def synthesize(coefficients: np.ndarray, height: int, width: int) -> np.ndarray:
    """The map [height, width, C] of coefficients [(l_max + 1)^2, C]: values at the texel centres."""
    l_max = round(len(coefficients) ** 0.5) - 1
    t = _tables(l_max)
    P = _row_polynomials(height, l_max)
    phi = 2 * np.pi * (np.arange(width) + 0.5) / width
    m = np.arange(l_max + 1)[:, None]
    waves = np.concatenate([np.cos(m * phi), np.sin(m[1:] * phi)])
    result = np.zeros((height, 2 * l_max + 1, coefficients.shape[-1]))
    for k in range(2 * l_max + 1):
        mine = np.flatnonzero(t.trig == k)
        result[:, k] = P[t.l[mine], t.m[mine[0]]].T @ coefficients[mine]
    return np.einsum("hkc,kw->hwc", result, waves)


def gaussian_bands(sharpness: np.ndarray, l_max: int = L_MAX) -> tuple[np.ndarray, np.ndarray]:
    """c_l [K, l_max + 1] of unit-flux spherical Gaussians, and dc_l / d(ln sharpness).

    c_l = I_{l+1/2}(lam) / I_{1/2}(lam), by the recurrence of modified spherical Bessel functions run downward, its
    stable direction.   [DLMF 10.51.4; Mardia and Jupp 2000, section 9.3]
    """
    from scipy.special import ive  # lights that are given need none of it

    lam = np.atleast_1d(np.asarray(sharpness, float))
    x = np.maximum(lam, 1e-4)
    # The two highest orders from the library, the others by i_{l-1} = i_{l+1} + (2 l + 1) / x i_l.
    i = np.empty((l_max + 2, len(x)))
    i[l_max + 1], i[l_max] = ive(l_max + 1.5, x), ive(l_max + 0.5, x)
    # Scaled so that the start is 1: at small x it would underflow when squared.
    scale = np.maximum(i[l_max], 1e-300)
    i[l_max + 1] /= scale
    i[l_max] = 1.0
    for l in range(l_max, 0, -1):
        i[l - 1] = i[l + 1] + (2 * l + 1) / x * i[l]
    c = i / i[0]
    # i_l' = i_{l+1} + (l / x) i_l, and i_0' = i_1   [DLMF 10.51.5]
    l = np.arange(l_max + 1)[:, None]
    slope = x * (c[1:] - c[:-1] * c[1]) + l * c[:-1]
    # Below the floor of x, c_l is proportional to lam^l.
    small = (lam / x) ** l
    return (c[:-1] * small).T, (slope * small).T


def gaussian_flux(sharpness: np.ndarray) -> np.ndarray:
    """Integral over the sphere of exp(sharpness (omega . axis - 1)): 2 pi (1 - exp(-2 sharpness)) / sharpness."""
    lam = np.asarray(sharpness, float)
    return 4 * np.pi * np.where(lam > 1e-8, -np.expm1(-2 * lam) / (2 * np.maximum(lam, 1e-8)), 1.0)


def project_gaussians(axis: np.ndarray, sharpness: np.ndarray, flux: np.ndarray, l_max: int = L_MAX) -> np.ndarray:
    """Coefficients [(l_max + 1)^2, C] of spherical Gaussians given by axis [K, 3], sharpness [K] and flux [K, C]."""
    if len(sharpness) == 0:
        return np.zeros(((l_max + 1) ** 2, np.shape(flux)[-1]))
    c, _ = gaussian_bands(sharpness, l_max)
    return (harmonics(axis, l_max) * c[:, _tables(l_max).l]).T @ flux


def project_directions(direction: np.ndarray, irradiance: np.ndarray, l_max: int = L_MAX) -> np.ndarray:
    """Coefficients [(l_max + 1)^2, C] of directional lights: direction [S, 3], irradiance [S, C]."""
    if len(direction) == 0:
        return np.zeros(((l_max + 1) ** 2, np.shape(irradiance)[-1]))
    return harmonics(direction, l_max).T @ irradiance


def degrees_of(l_max: int = L_MAX) -> np.ndarray:
    """Degree l [(l_max + 1)^2] of each coefficient."""
    return _tables(l_max).l


def power(coefficients: np.ndarray) -> np.ndarray:
    """Power of each degree: sum over m of squares, [l_max + 1, ...] of coefficients [(l_max + 1)^2, ...]."""
    l_max = round(len(coefficients) ** 0.5) - 1
    return np.add.reduceat(np.square(coefficients), np.arange(l_max + 1) ** 2, axis=0)
