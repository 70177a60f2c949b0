"""Twin of glsl/woven/ggx.glsl: microfacets (paper B Eq. 2-5; Walter et al. 2007), in float64."""

import numpy as np

from .fresnel import F_schlick


def _dot(a, b):
    return np.sum(np.asarray(a) * np.asarray(b), -1)


def D_GGX(h, roughness):
    """r^2 / (pi cos^4 (r^2 + tan^2)^2) of the angle between h [..., 3] and N.   [Mat 5, erratum E3]"""
    cos2 = np.asarray(h, float)[..., 2] ** 2
    sin2 = np.asarray(h, float)[..., 0] ** 2 + np.asarray(h, float)[..., 1] ** 2
    r2 = np.asarray(roughness, float) ** 2
    with np.errstate(divide="ignore", invalid="ignore"):
        D = r2 / (np.pi * cos2**2 * (r2 + sin2 / cos2) ** 2)
    return np.where(np.asarray(h)[..., 2] > 0, D, 0.0)


def G_1_smith(omega, roughness):
    """2 / (1 + sqrt(1 + r^2 tan^2)) of the angle between omega [..., 3] and N.   [Walter 2007, Eq. 34]"""
    omega = np.asarray(omega, float)
    with np.errstate(divide="ignore"):
        tan2 = (omega[..., 0] ** 2 + omega[..., 1] ** 2) / omega[..., 2] ** 2
    return 2 / (1 + np.sqrt(1 + np.asarray(roughness, float) ** 2 * tan2))


def F_exact(cos_lh, eta_1, eta_2):
    """Unpolarised Fresnel reflectance of a dielectric interface; 1 beyond the critical angle."""
    cos_lh = np.asarray(cos_lh, float)
    sin2_t = (np.asarray(eta_1) / eta_2) ** 2 * (1 - cos_lh**2)
    cos_t = np.sqrt(np.maximum(1 - sin2_t, 0))
    s = (eta_1 * cos_lh - eta_2 * cos_t) / (eta_1 * cos_lh + eta_2 * cos_t)
    p = (eta_1 * cos_t - eta_2 * cos_lh) / (eta_1 * cos_t + eta_2 * cos_lh)
    return np.where(sin2_t >= 1, 1.0, 0.5 * (s**2 + p**2))


def F_interface(cos_lh, eta_1, eta_2):
    """Schlick's reflectance, with the refracted ray's cosine from the denser side.   [Mat 4]"""
    cos_lh, eta_1, eta_2 = np.broadcast_arrays(np.asarray(cos_lh, float), eta_1, eta_2)
    cos2_t = 1 - (eta_1 / eta_2) ** 2 * (1 - cos_lh**2)
    cosine = np.where(eta_1 > eta_2, np.sqrt(np.maximum(cos2_t, 0)), cos_lh)
    F = F_schlick(((eta_1 - eta_2) / (eta_1 + eta_2)) ** 2, cosine)
    return np.where((eta_1 > eta_2) & (cos2_t <= 0), 1.0, F)


def h_t(omega_i, omega_o, eta_1, eta_2):
    """(h, |eta_1 omega_i + eta_2 omega_o|) [..., 4]; zero where no facet refracts.   [Walter 2007, Eq. 16]"""
    omega_i, omega_o = np.broadcast_arrays(np.asarray(omega_i, float), np.asarray(omega_o, float))
    h = -(np.asarray(eta_1)[..., None] * omega_i + np.asarray(eta_2)[..., None] * omega_o)
    size = np.linalg.norm(h, axis=-1)
    with np.errstate(divide="ignore", invalid="ignore"):
        h = np.where(h[..., 2:] < 0, -h, h) / size[..., None]
    valid = (size >= 1e-6) & (_dot(omega_i, h) > 0) & (_dot(omega_o, h) < 0)
    return np.where(valid[..., None], np.concatenate([h, size[..., None]], -1), 0.0)


def f_GGX_of(omega_i, omega_o, eta_1, eta_2, F, G, D):
    """Equation 2 with the three factors given.   [Mat 2, errata E5, E9; Walter 2007, Eq. 21]"""
    h = h_t(omega_i, omega_o, eta_1, eta_2)
    cos_lh, cos_vh = _dot(omega_i, h[..., :3]), _dot(omega_o, h[..., :3])
    cos_nl, cos_nv = np.asarray(omega_i)[..., 2], np.asarray(omega_o)[..., 2]
    with np.errstate(divide="ignore", invalid="ignore"):
        f = np.abs(cos_lh * cos_vh / (cos_nl * cos_nv)) * np.asarray(eta_2) ** 2 * (1 - F) * G * D
        f = f / (np.asarray(eta_1) * cos_lh + np.asarray(eta_2) * cos_vh) ** 2
    return np.where((h[..., 3] > 0) & (cos_nl > 0) & (cos_nv < 0), f, 0.0)


def f_GGX(omega_i, omega_o, roughness, eta_1, eta_2):
    """The BTDF of a rough interface, 1/sr.   [Mat 2, errata E3, E5, E9; Walter 2007, Eq. 21]"""
    h = h_t(omega_i, omega_o, eta_1, eta_2)[..., :3]
    F = F_interface(_dot(omega_i, h), eta_1, eta_2)
    G = G_1_smith(omega_i, roughness) * G_1_smith(omega_o, roughness)
    return f_GGX_of(omega_i, omega_o, eta_1, eta_2, F, G, D_GGX(h, roughness))


def f_straight(omega_i, omega_o, roughness):
    """D G / (4 cos_nl cos_nv) about the straight-through direction, 1/sr.   [own; Walter 2007, Eq. 20]"""
    omega_i, omega_o = np.broadcast_arrays(np.asarray(omega_i, float), np.asarray(omega_o, float))
    h = omega_i + omega_o * [1.0, 1.0, -1.0]
    with np.errstate(divide="ignore", invalid="ignore"):
        h = h / np.linalg.norm(h, axis=-1, keepdims=True)
        G = G_1_smith(omega_i, roughness) * G_1_smith(omega_o, roughness)
        f = D_GGX(h, roughness) * G / (4 * omega_i[..., 2] * -omega_o[..., 2])
    return np.where((omega_i[..., 2] > 0) & (omega_o[..., 2] < 0), f, 0.0)
