"""Twin of glsl/sg/azimuth.glsl: integrals over the azimuth (Mizutani et al. 2012, Eq. 14), by quadrature, in float64."""

import numpy as np

PANELS, ORDER = 64, 16


def azimuth_nodes():
    """Gauss-Legendre nodes and weights on [-pi/2, pi/2], fine enough for kappa_prime up to 1e5."""
    x, w = np.polynomial.legendre.leggauss(ORDER)
    edges = np.linspace(-np.pi / 2, np.pi / 2, PANELS + 1)
    middle, half = (edges[1:] + edges[:-1]) / 2, np.pi / PANELS / 2
    return (middle[:, None] + half * x).ravel(), np.tile(half * w, PANELS)


def integrate(phi_k, kappa_prime, factor):
    """The integral of exp(kappa_prime (cos(phi - phi_k) - 1)) factor(phi) over [-pi/2, pi/2]."""
    phi, weight = azimuth_nodes()
    phi_k, kappa_prime = np.asarray(phi_k, float)[..., None], np.asarray(kappa_prime, float)[..., None]
    return np.sum(weight * np.exp(-2 * kappa_prime * np.sin((phi - phi_k) / 2) ** 2) * factor(phi), -1)


def T_l(l, phi_o, phi_k, kappa_prime):
    """The integral of g_c(phi_i; phi_k, sigma_k_prime) cos^l((phi_i - phi_o) / 2), l the power itself.   [Miz 14]"""
    phi_o = np.asarray(phi_o, float)[..., None]
    return integrate(phi_k, kappa_prime, lambda phi: np.cos((phi - phi_o) / 2) ** l)


def azimuth_mass(phi_k, kappa_prime):
    """The integral of g_c(phi_i; phi_k, sigma_k_prime) |cos((phi_i - phi_k) / 2)|.   [own]"""
    at = np.asarray(phi_k, float)[..., None]
    return integrate(phi_k, kappa_prime, lambda phi: np.abs(np.cos((phi - at) / 2)))
