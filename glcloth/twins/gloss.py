"""Twin of glsl/sg/gloss.glsl, in float64."""

import numpy as np

from .shading_frame import orthogonal_part

ALPHA_LEAST = 2e-3
RINGS, RING = ((0.58578644, 0.85355339), (3.41421356, 0.14644661)), 5
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
    apart = np.clip(20 * np.asarray(alpha, float) - 0.8, 0, 1) * np.clip(20 * np.max(F_0, -1) - 1, 0, 1)
    L = 0.0
    for c, b in GGX_LOBES:
        lobe = 0.5 * b / (a**2 * np.maximum(_dot(N, omega_o), 0.05))
        total = lobe[..., None] * mirrored + sharpness[..., None] * xi
        both = np.maximum(np.linalg.norm(total, axis=-1), 1e-6)
        way = total / both[..., None]
        share = 1 - np.exp(-2 * both)
        y = orthogonal_part(np.cross(N, way), way)
        x = np.cross(y, way)
        for k in range(2 * RING):
            at, weight = RINGS[k // RING]
            fall = -np.log(1 - (1 - np.exp(-apart * at)) * share)
            versine = fall / both
            r = np.sqrt(np.maximum(versine * (2 - versine), 0))
            turn = 2 * np.pi / RING * (k + 0.5 * (k // RING))
            omega_i = (1 - versine)[..., None] * way + r[..., None] * (np.cos(turn) * x + np.sin(turn) * y)
            cos_i, h = np.maximum(_dot(N, omega_i), 0), _unit(omega_i + omega_o)
            cos_h, s, off = np.maximum(_dot(N, h), 1e-3), np.cross(N, h), omega_i - xi
            height = np.exp(fall - b * _dot(s, s) / (a * cos_h) ** 2 - 0.5 * sharpness * _dot(off, off))
            masked = V_smith(cos_i, np.maximum(_dot(N, omega_o), 1e-3), a) * cos_i
            scale = c * 2 * share / (RING * both * a**2) * weight * height * masked / cos_h**4
            L = L + F_color(F_0, _dot(omega_o, h)) * scale[..., None]
    return L


def F_repeated_lobes(F_0, albedos, sharpness):
    share = (sharpness / (1 + sharpness))[..., None]
    return (1 - share) * F_repeated(F_0, albedos[..., 1]) + share * F_repeated(F_0, albedos[..., 0])
