"""Twin of glsl/direct/slots.glsl: terms of the microcylinder model for several tangents at once, in float64."""

import numpy as np

from .fresnel import F_schlick
from .weight import D_mask

ANGLE_SERIES = np.array([2.0, 1.0 / 3.0, 4.0 / 45.0, 0.067381])  # of angle^2 in x = 1 - cos(angle): x, x^2, x^3, x^5


def g_of_cos(cos_angle, series):
    """g(angle; 0, sigma) by the angle's cosine; series [..., 4] = ANGLE_SERIES times -1 / (sigma^2 ln 2).   [Miz, below 6]"""
    return np.exp(-((np.arccos(np.clip(cos_angle, -1, 1)) / sigma_of_series(series)) ** 2))


def sigma_of_series(series):
    """sigma [..., 1] of such a series."""
    return np.sqrt(ANGLE_SERIES[0] / (-np.asarray(series)[..., :1] * np.log(2)))


def D_masks(x, y, z):
    """(1 - x) y z + x min(y, z).   [Miz, below 6]"""
    return D_mask(x, y, z)


def F_slots(F_0, cos_theta_d, cos_half_phi_d):
    """Schlick's Fresnel reflectance.   [Miz 12]"""
    return F_schlick(F_0, np.asarray(cos_theta_d) * cos_half_phi_d)


def twice_atan(y):
    """2 atan(y).   [own]"""
    return 2 * np.arctan(y)


def tangent_slots(along, z, cos_tilt, sin_tilt):
    """omega . t and omega . n [..., 8] of directions that lie `along` the yarn and z above the surface.   [own]"""
    z = np.asarray(z)[..., None]
    return np.concatenate([along * cos_tilt - z * sin_tilt, along * sin_tilt + z * cos_tilt], -1)


def theta_slots(t):
    """theta by its sine.   [own]"""
    return np.arcsin(t)


def lobe_slots(theta_i, start, slope):
    """2^-(start + slope theta_i)^2.   [Miz 4]"""
    return np.exp2(-((start + slope * theta_i) ** 2))


def scatter_slots(t, cos_theta_i, cos_phi_i, cos_phi_d, sin_theta_o, cos_theta_o, cos_phi_o, F_0, series):
    """M, F_r, cos(phi_d / 2) / 2 and 4 cos^2(theta_d), [..., 16], by angles.   [Miz 5-6, 12]"""
    cos_half_phi_d = np.cos(np.arccos(np.clip(cos_phi_d, -1, 1)) / 2)
    cos_theta_d = np.cos((np.arctan2(t, cos_theta_i) - np.arctan2(sin_theta_o, cos_theta_o)) / 2)
    M = D_mask(g_of_cos(cos_phi_d, series), cos_phi_i, cos_phi_o)
    F_r = F_schlick(F_0, cos_theta_d * cos_half_phi_d)
    return np.concatenate([M, F_r, cos_half_phi_d / 2, 4 * cos_theta_d**2], -1)
