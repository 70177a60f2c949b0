"""Twin of the Lambertians' light: a spherical Gaussian's irradiance by the clamped cosine, in float64."""

import numpy as np

NODES = 256


def gaussian_irradiance(sharpness, cos_theta):
    """E [...] = integral of exp(kappa (omega . xi - 1)) max(omega . N, 0) over the sphere, cos_theta = xi . N.   [own]

    About xi the clamped cosine has a closed form at each polar angle; over the polar angle u = exp(kappa (cos - 1)) is
    the variable, in which the Gaussian is flat: E = integral of M(u) du / kappa. Gauss-Legendre, error below 1e-5 of all.
    """
    kappa = np.maximum(np.asarray(sharpness, float), 1e-6)[..., None]
    c = np.clip(np.asarray(cos_theta, float), -1.0, 1.0)[..., None]
    x, weight = np.polynomial.legendre.leggauss(NODES)
    t, weight = (x + 1.0) / 2.0, weight / 2.0
    whole = -np.expm1(-2.0 * kappa)
    z = np.clip(1.0 + np.log1p(-t * whole) / kappa, -1.0, 1.0)
    r = np.sqrt(np.maximum(1.0 - z * z, 0.0))
    # max(a + b cos(psi), 0) integrated over psi.
    a, b = c * z, np.sqrt(np.maximum(1.0 - c * c, 0.0)) * r
    psi = np.arccos(np.clip(-a / np.maximum(b, 1e-300), -1.0, 1.0))
    M = 2.0 * (a * psi + np.sqrt(np.maximum(b * b - a * a, 0.0)))
    return (M * weight).sum(-1) * (whole / kappa)[..., 0]
