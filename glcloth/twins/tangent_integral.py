"""Twin of glsl/sg/tangent_integral.glsl: parts of the paper method's integrals of one tangent, in float64."""

import numpy as np

from .fresnel_sum import surface_sum, volume_sum
from .gaussian import g_c_product, sigma_of_sharpness


def theta_gaussians(theta_k, sharpness, theta_o, k_d, gamma_s, gamma_v):
    """(mu, sigma, factor) [..., 3, 3] of the Gaussians of theta_i: columns; rows: surface, volume, isotropic.   [Miz 11-17]

    The lobes are g_u(theta_h; 0, gamma), Gaussians of theta_i about -theta_o of width 2 gamma.
    """
    theta_k, sharpness, theta_o, k_d, gamma_s, gamma_v = np.broadcast_arrays(
        *(np.asarray(a, float) for a in (theta_k, sharpness, theta_o, k_d, gamma_s, gamma_v))
    )
    rows = []
    for gamma, share in ((gamma_s, np.ones_like(k_d)), (gamma_v, 1 - k_d)):
        product = g_c_product(theta_k, sharpness, -theta_o, 2 / (2 * gamma) ** 2)
        sigma = sigma_of_sharpness(product[..., 1])
        rows.append((product[..., 0], sigma, share * product[..., 2] * sigma / (np.sqrt(np.pi) * gamma)))
    sigma = sigma_of_sharpness(sharpness)
    rows.append((theta_k, sigma, k_d * sigma))
    return np.stack([np.stack(row, -1) for row in rows], -2)


def node_terms(weight, cos_theta, cos_theta_d, slope, F_0, T_1, T_5, T_9):
    """The share of a node in (I_s, I_v / A), [..., 2].   [Miz 13-16]"""
    surface = weight[..., 0] * surface_sum(F_0, cos_theta_d, T_1, T_5)
    volume = (weight[..., 1] + weight[..., 2]) * slope * volume_sum(F_0, cos_theta_d, T_1, T_5, T_9)
    return ((cos_theta / cos_theta_d) ** 2)[..., None] * np.stack([surface, volume], -1)
