"""Twin of glsl/core/equirect.glsl, in float64."""

import numpy as np


def uv_from_direction(omega):
    """Map coordinates [..., 2] of unit directions [..., 3]: u = 1/4 along +x, 1/2 along +z; v = 0 at the zenith.   [own]"""
    omega = np.asarray(omega, float)
    u = np.arctan2(omega[..., 0], -omega[..., 2]) / (2 * np.pi) % 1.0
    return np.stack([u, np.arctan2(np.hypot(omega[..., 0], omega[..., 2]), omega[..., 1]) / np.pi], -1)
