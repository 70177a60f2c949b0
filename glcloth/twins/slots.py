"""Twin of glsl/direct/slots.glsl: terms of the microcylinder model for several tangents at once, in float64."""

import numpy as np

from .fresnel import F_schlick
from .weight import D_mask

ANGLE_SERIES = np.array([2.0, 1.0 / 3.0, 4.0 / 45.0, 0.067381])  # of angle^2 in x = 1 - cos(angle): x, x^2, x^3, x^5


def g_of_cos(cos_angle, series):
    """g(angle; 0, sigma) by the angle's cosine; series [..., 4] = ANGLE_SERIES times -1 / (sigma^2 ln 2).   [Miz, below 6]"""
    angle = np.arccos(np.clip(cos_angle, -1, 1))
    inv_sigma2 = -np.asarray(series)[..., :1] * np.log(2) / ANGLE_SERIES[0]
    return np.exp(-(angle**2) * inv_sigma2)


def D_masks(x, y, z):
    """(1 - x) y z + x min(y, z).   [Miz, below 6]"""
    return D_mask(x, y, z)


def F_slots(F_0, cos_theta_d, cos_half_phi_d):
    """Schlick's Fresnel reflectance.   [Miz 12]"""
    return F_schlick(F_0, np.asarray(cos_theta_d) * cos_half_phi_d)


def twice_atan(y):
    """2 atan(y).   [own]"""
    return 2 * np.arctan(y)
