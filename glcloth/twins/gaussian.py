"""Twin of glsl/sg/gaussian.glsl: the Gaussians of Mizutani et al. 2012 (Eq. 1-4, 10, 17), as printed, in float64."""

import numpy as np


def G_sg(omega, xi, sigma):
    """Spherical Gaussian of unit vectors [..., 3].   [Miz 1]"""
    return np.exp(2.0 * (np.sum(np.asarray(omega) * xi, axis=-1) - 1.0) / np.asarray(sigma) ** 2)


def g_c(x, mu, sigma):
    """Circular Gaussian.   [Miz 2]"""
    return np.exp(2.0 * (np.cos(np.asarray(x) - mu) - 1.0) / np.asarray(sigma) ** 2)


def g(x, mu, sigma):
    """Gaussian with unit height.   [Miz 3]"""
    return np.exp(-(((np.asarray(x) - mu) / sigma) ** 2))


def sigma_k_prime(sigma_k, theta_i, theta_k):
    """Width in phi of the spherical Gaussian's factor at inclination theta_i.   [Miz 10]"""
    return sigma_k / np.sqrt(np.cos(theta_i) * np.cos(theta_k))


def sigma_of_sharpness(sharpness):
    """The width sigma of a Gaussian with sharpness 2 / sigma^2."""
    return np.sqrt(2.0 / np.asarray(sharpness))


def g_c_product(mu_1, sharpness_1, mu_2, sharpness_2):
    """(mu_3, 2 / sigma_3^2, alpha) [..., 3] of the product of two circular Gaussians.   [Miz 17, erratum E1]"""
    sigma_1, sigma_2 = sigma_of_sharpness(sharpness_1), sigma_of_sharpness(sharpness_2)
    m = np.cos(mu_1) / sigma_1**2 + np.cos(mu_2) / sigma_2**2
    n = np.sin(mu_1) / sigma_1**2 + np.sin(mu_2) / sigma_2**2
    sigma_3 = (m**2 + n**2) ** -0.25
    alpha = np.exp(-2.0 / sigma_1**2 - 2.0 / sigma_2**2 + 2.0 / sigma_3**2)
    return np.stack(np.broadcast_arrays(np.arctan2(n, m), 2.0 / sigma_3**2, alpha), -1)
