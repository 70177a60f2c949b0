"""Twin of glsl/direct/node.glsl: nodes of a spherical Gaussian, in float64."""

import numpy as np


def column_width(sharpness):
    """The width, in radians, over which a Gaussian sinks below the horizon: columns are dense there.   [own]"""
    return 1.5 / np.sqrt(np.asarray(sharpness, float) + 1.0)


def column_of(angle, width):
    """The place [...] in 0..1 of an axis at an angle [...] from N, 0..pi; dense about the horizon.   [own]"""
    reach = np.arctan(0.5 * np.pi / width)
    return 0.5 + 0.5 * np.arctan((angle - 0.5 * np.pi) / width) / reach


def angle_at_column(column, width):
    """The inverse of `column_of`.   [own]"""
    reach = np.arctan(0.5 * np.pi / width)
    return 0.5 * np.pi + width * np.tan((2.0 * np.asarray(column) - 1.0) * reach)


def azimuth(xi):
    """The horizontal unit direction [..., 2] under xi [..., 3]; (1, 0) at the zenith.   [own]"""
    h = np.hypot(xi[..., 0], xi[..., 1])[..., None]
    return np.where(h > 1e-5, xi[..., :2] / np.maximum(h, 1e-300), np.array([1.0, 0.0]))


def direction_from_node(node, xi, e):
    """a u + b v + c xi [..., 3] of a node (a, b, c), with u = N x e and v = d xi / d angle.   [own]"""
    zero = np.zeros_like(xi[..., 0])
    u = np.stack([-e[..., 1], e[..., 0], zero], -1)
    h = (xi[..., :2] * e).sum(-1)
    v = np.stack([xi[..., 2] * e[..., 0], xi[..., 2] * e[..., 1], -h], -1)
    return node[..., :1] * u + node[..., 1:2] * v + node[..., 2:] * xi
