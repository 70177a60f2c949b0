"""Twin of glsl/trace/intersect.glsl: rays against boxes and triangles, triangles against planes, in float64."""

import numpy as np


def safe_inverse(d):
    """1 / d [..., 3]; components below 1e-20 count as 1e-20."""
    d = np.asarray(d, float)
    return 1 / np.where(np.abs(d) < 1e-20, 1e-20, d)


def slab(o, inv_d, low, high):
    """(t_0, t_1) [..., 2] of rays against boxes.   [Kay, Kajiya 1986]"""
    a, b = (low - o) * inv_d, (high - o) * inv_d
    return np.stack([np.minimum(a, b).max(-1), np.maximum(a, b).min(-1)], -1)


def longest_axis(d):
    """The axis [...] along which d [..., 3] is longest; z before x before y when they are alike.   [Woop 2013]"""
    a = np.abs(np.asarray(d, float))
    return np.where(a[..., 2] >= a[..., :2].max(-1), 2, np.where(a[..., 0] >= a[..., 1], 0, 1))


def axis_last(v, axis):
    """v [..., 3] turned cyclically so that component `axis` comes last.   [Woop 2013]"""
    index = (np.asarray(axis)[..., None] + [1, 2, 3]) % 3
    return np.take_along_axis(np.asarray(v, float), index, -1)


def shear_of(d):
    """(d_x / d_z, d_y / d_z, 1 / d_z) [..., 3].   [Woop 2013]"""
    d = np.asarray(d, float)
    return np.stack([d[..., 0] / d[..., 2], d[..., 1] / d[..., 2], 1 / d[..., 2]], -1)


def edge_function(p, q):
    """(p - q) x (p + q) = 2 p x q [...] of points [..., 2].   [own]"""
    p, q = np.asarray(p, float), np.asarray(q, float)
    return 2 * (p[..., 0] * q[..., 1] - p[..., 1] * q[..., 0])


def sheared(p, shear):
    """p [..., 3] seen along the ray: [..., 2].   [Woop 2013]"""
    return p[..., :2] - shear[..., :2] * p[..., 2:]


def hit_edges(edges, depths, shear):
    """(t, v, w, determinant) [..., 4] from edge functions and depths [..., 3] of the corners; t = -1: a miss.   [Woop 2013]"""
    edges = np.asarray(edges, float)
    total = edges.sum(-1)
    with np.errstate(divide="ignore", invalid="ignore"):
        weights = edges / total[..., None]
        t = (weights * depths).sum(-1) * shear[..., 2]
        hit = (total != 0) & (weights >= 0).all(-1)
    return np.where(
        hit[..., None], np.stack([t, weights[..., 1], weights[..., 2], 0.5 * total], -1), [-1.0, 0.0, 0.0, 0.0]
    )


def hit_triangle(a, b, c, shear):
    """(t, v, w, determinant) [..., 4] of a ray from the origin along (0, 0, 1) sheared back; t = -1: a miss.

    Möller and Trumbore 1997, so that nothing is shared with Woop's edge functions.
    """
    d = np.stack([shear[..., 0], shear[..., 1], np.ones_like(shear[..., 0])], -1)
    e_1, e_2 = b - a, c - a
    p = np.cross(d, e_2)
    determinant = np.sum(e_1 * p, -1)
    with np.errstate(divide="ignore", invalid="ignore"):  # a triangle without area is no hit
        v = np.sum(-a * p, -1) / determinant
        q = np.cross(-a, e_1)
        w = np.sum(d * q, -1) / determinant
        t = np.sum(e_2 * q, -1) / determinant * shear[..., 2]
        hit = (determinant != 0) & (v >= 0) & (w >= 0) & (v + w <= 1)
    return np.where(hit[..., None], np.stack([t, v, w, determinant], -1), [-1.0, 0.0, 0.0, 0.0])


def behind_layer(t):
    """Where a ray goes on behind its hit at t.   [own]"""
    return t + 1e-5 * (1.0 + t)


def clipped_box(a, b, c, n, plane, side):
    """Rows low, high, (exists, 0, 0) [..., 3, 3] as columns of a matrix, by cutting the polygon's edges.   [Zhou 2008]"""
    corners = np.stack(np.broadcast_arrays(a, b, c), -2)
    x = np.sum(corners * np.asarray(n, float)[..., None, :], -1)
    distance = np.asarray(side)[..., None] * (np.asarray(plane)[..., None] - x)
    points, valid = [corners], [distance >= 0]
    for i, j in ((0, 1), (1, 2), (2, 0)):
        with np.errstate(divide="ignore", invalid="ignore"):
            f = distance[..., i] / (distance[..., i] - distance[..., j])
        p = corners[..., i, :] + f[..., None] * (corners[..., j, :] - corners[..., i, :])
        points.append(p[..., None, :])
        valid.append(((distance[..., i] < 0) != (distance[..., j] < 0))[..., None])
    points, valid = np.concatenate(points, -2), np.concatenate(valid, -1)[..., None]
    some = valid.any(-2)
    low = np.where(some, np.where(valid, points, np.inf).min(-2), 0)
    high = np.where(some, np.where(valid, points, -np.inf).max(-2), 0)
    flag = np.where(some, [1.0, 0.0, 0.0], 0.0)
    return np.stack([low, high, flag], -1)
