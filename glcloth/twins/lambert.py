"""Twin of the Lambertians' light: a spherical Gaussian's irradiance by the clamped cosine, in float64."""

from functools import lru_cache

import numpy as np

NODES = 256


@lru_cache(maxsize=1)
def _legendre(n):
    """Nodes and weights [n] of Gauss-Legendre quadrature, by Newton's method. NumPy's takes the eigenvalues of a full matrix,
    half a second where other processes want its threads."""
    x = -np.cos(np.pi * (np.arange(n) + 0.75) / (n + 0.5))
    for _ in range(6):
        before, p = np.ones(n), x
        for k in range(2, n + 1):
            before, p = p, ((2 * k - 1) * x * p - (k - 1) * before) / k
        slope = n * (x * p - before) / (x * x - 1.0)
        x = x - p / slope
    return x, 2.0 / ((1.0 - x * x) * slope**2)


def gaussian_irradiance(sharpness, cos_theta):
    """E [...] = integral of exp(kappa (omega . xi - 1)) max(omega . N, 0) over the sphere, cos_theta = xi . N.   [own]

    About xi the clamped cosine has a closed form at each polar angle; over the polar angle u = exp(kappa (cos - 1)) is
    the variable, in which the Gaussian is flat: E = integral of M(u) du / kappa. Gauss-Legendre, error below 1e-5 of all.
    """
    kappa = np.maximum(np.asarray(sharpness, float), 1e-6)[..., None]
    c = np.clip(np.asarray(cos_theta, float), -1.0, 1.0)[..., None]
    x, weight = _legendre(NODES)
    t, weight = (x + 1.0) / 2.0, weight / 2.0
    whole = -np.expm1(-2.0 * kappa)
    z = np.clip(1.0 + np.log1p(-t * whole) / kappa, -1.0, 1.0)
    r = np.sqrt(np.maximum(1.0 - z * z, 0.0))
    # max(a + b cos(psi), 0) integrated over psi.
    a, b = c * z, np.sqrt(np.maximum(1.0 - c * c, 0.0)) * r
    psi = np.arccos(np.clip(-a / np.maximum(b, 1e-300), -1.0, 1.0))
    M = 2.0 * (a * psi + np.sqrt(np.maximum(b * b - a * a, 0.0)))
    return (M * weight).sum(-1) * (whole / kappa)[..., 0]
