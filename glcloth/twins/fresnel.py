"""Twin of glsl/core/fresnel.glsl: Schlick's approximation (Mizutani et al. 2012, Eq. 12), in float64."""

import numpy as np


def F_0(eta):
    """Reflectance at normal incidence.   [Miz 12]"""
    return ((1.0 - np.asarray(eta)) / (1.0 + np.asarray(eta))) ** 2


def F_schlick(F_0, cos_theta):
    """Schlick's approximation of the Fresnel reflectance.   [Miz 12]"""
    return F_0 + (1.0 - F_0) * (1.0 - np.asarray(cos_theta)) ** 5
