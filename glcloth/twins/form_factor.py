"""Twin of glsl/trace/form_factor.glsl: form factors from a point to polygons (Lambert; Baum 1989), in float64.

Corners [..., 3] are relative to the point; n [..., 3] is its unit normal.
"""

import numpy as np


def angle_of(l, a, b):
    """The angle between a and b whose cross product is l long, 0 to pi.   [own]"""
    a, b = np.asarray(a, float), np.asarray(b, float)
    return np.arctan2(l, (a * b).sum(-1))


def edge_factor(a, b, n):
    """What the edge from a to b adds to 2 pi F.   [Baum 1989, Eq. 7]"""
    c = np.cross(a, b)
    l = np.linalg.norm(c, axis=-1)
    return np.where(l > 1e-12, angle_of(l, a, b) * (c * n).sum(-1) / np.maximum(l, 1e-12), 0.0)


def horizon_point(a, b, n):
    """Where the line through a and b meets the horizon of n; a where it runs along it.   [own]"""
    a, b, n = (np.asarray(v, float) for v in (a, b, n))
    z = (a * n).sum(-1)
    fall = z - (b * n).sum(-1)
    return a + np.where(fall != 0, z / np.where(fall != 0, fall, 1.0), 0.0)[..., None] * (b - a)


def clipped_edge_factor(a, b, n):
    """`edge_factor` of the part of the edge above the horizon.   [own]"""
    a, b, n = (np.asarray(v, float) for v in (a, b, n))
    a_up, b_up = (a * n).sum(-1) >= 0, (b * n).sum(-1) >= 0
    m = horizon_point(a, b, n)
    factor = edge_factor(np.where(a_up[..., None], a, m), np.where(b_up[..., None], b, m), n)
    return np.where(a_up | b_up, factor, 0.0)


def quad_factor(a, b, c, d, n):
    """The factor of a flat convex quadrilateral, counter-clockwise seen from the point; c = d makes it a triangle.   [own]"""
    corners = [np.asarray(v, float) for v in (a, b, c, d)]
    n = np.asarray(n, float)
    total, left, entered, leaves = 0.0, 0.0, 0.0, False
    for p, q in zip(corners, [*corners[1:], corners[0]], strict=True):
        p_up, q_up = (p * n).sum(-1) >= 0, (q * n).sum(-1) >= 0
        m = horizon_point(p, q, n)
        total = total + clipped_edge_factor(p, q, n)
        left = left + np.where((p_up & ~q_up)[..., None], m, 0.0)
        entered = entered + np.where((~p_up & q_up)[..., None], m, 0.0)
        leaves = leaves | (p_up & ~q_up)
    total = total + np.where(leaves, edge_factor(left, entered, n), 0.0)
    return np.maximum(-total, 0.0) / (2 * np.pi)


def lean_weights(lean):
    """By what of values at the leans 0, 0.1, 0.25 and 0.5 one at another lean is interpolated, [..., 4].   [own]"""
    s = np.clip(np.asarray(lean, float), -0.02, 0.5)
    out = np.zeros((*s.shape, 4))
    for first, here in ((0, s < 0.25), (1, s >= 0.25)):
        known = np.array([0.0, 0.1, 0.25, 0.5])[first : first + 3]
        for k in range(3):
            others = np.delete(known, k)
            value = (s - others[0]) * (s - others[1]) / np.prod(known[k] - others)
            out[..., first + k] = np.where(here, value, out[..., first + k])
    return out
