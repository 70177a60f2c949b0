"""Twin of glsl/fibre/lobe.glsl: directions drawn from the lobes of one tangent, in float64."""

import numpy as np

from .erf import erf, erf_inverse
from .fresnel import F_0, F_schlick
from .scatter import g_u

LEAST_COS = 0.1


def _theta(omega):
    return np.arctan2(omega[..., 0], np.hypot(omega[..., 1], omega[..., 2]))


def lobe_ends(omega_o, gamma):
    """erf(theta_h / gamma) [..., 2] where theta_i is -90 and 90 degrees.   [own]"""
    half = 0.5 * _theta(np.asarray(omega_o, float))
    return np.stack([erf((half - np.pi / 4) / gamma), erf((half + np.pi / 4) / gamma)], -1)


def lobe_weights(omega_o, weight, A, eta, k_d, ends_v, ends_s):
    """About how much light (volume, surface) [..., 2] each lobe sends toward omega_o; A: luminance of the albedo.   [own]"""
    omega_o, ends_v, ends_s = (np.asarray(v, float) for v in (omega_o, ends_v, ends_s))
    theta, phi = _theta(omega_o), np.arctan2(omega_o[..., 1], omega_o[..., 2])
    cos_psi = omega_o[..., 2] / np.maximum(np.hypot(omega_o[..., 0], omega_o[..., 2]), 1e-9)
    F, c = F_schlick(F_0(eta), np.cos(theta) * np.cos(phi / 2)), np.maximum(np.cos(theta), LEAST_COS)
    volume = np.maximum(A, 1e-4) * (1 - F) ** 2 * (1 - np.asarray(k_d)) * (ends_v[..., 1] - ends_v[..., 0]) / c**2
    surface = 2 * F * (ends_s[..., 1] - ends_s[..., 0]) / c
    seen = np.asarray(weight) * cos_psi * (omega_o[..., 2] > 0)
    return seen[..., None] * np.stack([volume, surface], -1)


def lobe_direction(omega_o, gamma, ends, lobe, u):
    """A direction [..., 3] of a lobe (1: surface, 0: volume) by u [..., 2] from 0 to 1.   [own]"""
    omega_o, ends, u = (np.asarray(v, float) for v in (omega_o, ends, u))
    at = ends[..., 0] + u[..., 0] * (ends[..., 1] - ends[..., 0])
    theta_h = gamma * erf_inverse(np.clip(at, -0.9999998, 0.9999998))
    theta = np.clip(2 * theta_h - _theta(omega_o), -np.pi / 2, np.pi / 2)
    phi_o = np.arctan2(omega_o[..., 1], omega_o[..., 2])
    a, b = np.sin(-np.pi / 4 - phi_o / 2), np.sin(np.pi / 4 - phi_o / 2)
    surface = phi_o + 2 * np.arcsin(np.clip(a + u[..., 1] * (b - a), -1, 1))
    phi = np.where(np.asarray(lobe) == 1, surface, np.arcsin(np.clip(2 * u[..., 1] - 1, -1, 1)))
    return np.stack([np.sin(theta), np.cos(theta) * np.sin(phi), np.cos(theta) * np.cos(phi)], -1)


def lobe_pdf(omega_i, omega_o, gamma, ends, lobe):
    """The density [...] of omega_i among the directions of a lobe, per solid angle.   [own]"""
    omega_i, omega_o, ends = (np.asarray(v, float) for v in (omega_i, omega_o, ends))
    theta_i = _theta(omega_i)
    of_theta = g_u(0.5 * (theta_i + _theta(omega_o)), gamma) / np.maximum(ends[..., 1] - ends[..., 0], 1e-6)
    phi_i, phi_o = (np.arctan2(omega[..., 1], omega[..., 2]) for omega in (omega_i, omega_o))
    surface = np.abs(np.cos((phi_i - phi_o) / 2)) / (2 * np.sqrt(2) * np.cos(phi_o / 2))
    of_phi = np.where(np.asarray(lobe) == 1, surface, 0.5 * np.cos(phi_i))
    return np.where(omega_i[..., 2] > 0, of_theta * of_phi / np.maximum(np.cos(theta_i), 1e-6), 0.0)
