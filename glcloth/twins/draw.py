"""Twin of glsl/sg/draw.glsl: directions drawn from a spherical Gaussian, in float64."""

import numpy as np

from .shading_frame import orthogonal_part

WIDE = 0.05


def gaussian_direction(xi, sharpness, u):
    """A direction [..., 3] by u [..., 2] from 0 to 1, by inverting the distribution of its cosine to xi.   [own]"""
    xi, sharpness, u = (np.asarray(v, float) for v in (xi, sharpness, u))
    wide = np.maximum(sharpness, WIDE)
    below = -np.log(np.maximum(np.exp(-2 * wide) * (1 - u[..., 0]) + u[..., 0], 1e-38)) / wide
    below = np.where(sharpness > WIDE, below, 2 - 2 * u[..., 0])[..., None]
    x = orthogonal_part(np.stack([xi[..., 1], xi[..., 2], xi[..., 0]], -1), xi)
    phi = 2 * np.pi * u[..., 1:]
    across = np.cos(phi) * x + np.sin(phi) * np.cross(xi, x)
    omega = np.sqrt(np.maximum(below * (2 - below), 0)) * across + (1 - below) * xi
    return omega / np.linalg.norm(omega, axis=-1, keepdims=True)


def gaussian_pdf(value, sharpness):
    """The density [...] of such directions where the Gaussian is `value`, per solid angle.   [own]"""
    wide = np.maximum(sharpness, WIDE)
    pdf = np.asarray(value) * wide / (2 * np.pi * (1 - np.exp(-2 * wide)))
    return np.where(np.asarray(sharpness) > WIDE, pdf, 0.25 / np.pi)
