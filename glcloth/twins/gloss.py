"""Twin of glsl/sg/gloss.glsl, in float64."""

import numpy as np

ALPHA_LEAST = 2e-3
GGX_LOBES = ((0.60319418, 2.61482955), (0.36280869, 0.70543652), (0.02762133, 0.10839955))


def _dot(a, b):
    return np.sum(a * b, axis=-1)


def _unit(v):
    return v / np.maximum(np.linalg.norm(v, axis=-1, keepdims=True), 1e-6)


def V_smith(cos_i, cos_o, alpha):
    masking = [c_1 * np.sqrt(alpha**2 + (1 - alpha**2) * c_2**2) for c_1, c_2 in ((cos_o, cos_i), (cos_i, cos_o))]
    return 0.5 / np.maximum(sum(masking), 1e-6)


def F_color(F_0, cos_theta):
    return F_0 + (1 - F_0) * ((1 - np.clip(cos_theta, 0, 1)) ** 5)[..., None]


def F_repeated(F_0, albedo):
    return 1 + F_0 * (1 / np.maximum(albedo, 1e-3) - 1)[..., None]


def gloss_albedo(cos_o, alpha, n=64):
    """The share [...] of light that leaves GGX after one reflection where F is 1: the integral of f_gloss, over n * n normals
    by their own distribution."""
    a = np.maximum(alpha, ALPHA_LEAST)[..., None, None]
    cos_o = np.maximum(cos_o, 1e-3)[..., None, None]
    u = (np.arange(n) + 0.5) / n
    cos_h = np.sqrt((1 - u) / (1 + (a**2 - 1) * u))[..., :]
    cos_oh = np.sqrt(1 - cos_o**2) * np.sqrt(1 - cos_h**2) * np.cos(2 * np.pi * u)[:, None] + cos_o * cos_h
    cos_i = 2 * cos_oh * cos_h - cos_o
    seen = (cos_i > 0) & (cos_oh > 0)
    lit = np.maximum(cos_i, 0)
    return np.where(seen, V_smith(lit, cos_o, a) * lit * 4 * cos_oh / cos_h, 0).mean((-1, -2))


def gaussian_gloss_albedo(cos_o, alpha):
    """As gloss_albedo, of gloss_of_gaussian: its radiance [...] in even light of 1."""
    cos_o = np.maximum(cos_o, 1e-3)
    omega_o = np.stack([np.sqrt(1 - cos_o**2), 0 * cos_o, cos_o], -1)
    up = np.broadcast_to([0.0, 0.0, 1.0], omega_o.shape)
    even = np.full(cos_o.shape, 1e-4)
    return gloss_of_gaussian(up, up, even, omega_o, np.ones(omega_o.shape), alpha)[..., 0]


def f_gloss(N, omega_i, omega_o, F_0, alpha):
    a = np.maximum(alpha, ALPHA_LEAST)
    cos_i, cos_o = _dot(N, omega_i), np.maximum(_dot(N, omega_o), 1e-3)
    h = _unit(omega_i + omega_o)
    cos_h = _dot(N, h)
    D = a**2 / (np.pi * (a**2 * cos_h**2 + _dot(np.cross(N, h), np.cross(N, h))) ** 2)
    lit = np.maximum(cos_i, 0)
    return F_color(F_0, _dot(omega_o, h)) * (D * V_smith(lit, cos_o, a) * lit)[..., None]


def gloss_of_gaussian(N, xi, sharpness, omega_o, F_0, alpha):
    a = np.maximum(alpha, ALPHA_LEAST)
    mirrored = 2 * _dot(N, omega_o)[..., None] * N - omega_o
    L = 0.0
    for c, b in GGX_LOBES:
        lobe = 0.5 * b / (a**2 * np.maximum(_dot(N, omega_o), 0.05))
        total = lobe[..., None] * mirrored + sharpness[..., None] * xi
        both = np.linalg.norm(total, axis=-1)
        way = _unit(total)
        lost = lobe * sharpness * _dot(mirrored - xi, mirrored - xi) / np.maximum(both + lobe + sharpness, 1e-6)
        product = 2 * np.pi * (1 - np.exp(-2 * both)) / np.maximum(both, 1e-6) * np.exp(-lost)
        cos_i = np.maximum(_dot(N, way), 0)
        shape = V_smith(cos_i, np.maximum(_dot(N, omega_o), 1e-3), a) * cos_i / (np.pi * a**2)
        L = L + F_color(F_0, _dot(omega_o, _unit(way + omega_o))) * (c * product * shape)[..., None]
    return L
