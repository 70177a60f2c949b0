"""Twin of glsl/direct/slots.glsl: terms of the microcylinder model for several tangents at once, in float64."""

import numpy as np

from .fresnel import F_schlick
from .weight import D_mask


def square_angle(x):
    """The square of the angle whose cosine is 1 - x.   [own]"""
    return np.arccos(np.clip(1.0 - np.asarray(x, float), -1, 1)) ** 2


def g_of_cos(cos_angle, log2_e_over_sigma2):
    """g(angle; 0, sigma) by the angle's cosine.   [Miz, below 6]"""
    angle = np.arccos(np.clip(cos_angle, -1, 1))
    return np.exp(-(angle**2) * np.asarray(log2_e_over_sigma2)[..., None] * np.log(2))


def D_masks(x, y, z):
    """(1 - x) y z + x min(y, z).   [Miz, below 6]"""
    return D_mask(x, y, z)


def F_slots(F_0, cos_theta_d, cos_half_phi_d):
    """Schlick's Fresnel reflectance.   [Miz 12]"""
    return F_schlick(F_0, np.asarray(cos_theta_d) * cos_half_phi_d)
