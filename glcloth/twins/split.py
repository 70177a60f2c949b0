"""Twin of glsl/trace/split.glsl: where a large node of the kd-tree is split, in float64."""

import numpy as np


def plane_fraction(k, count):
    """Where plane k of `count`, evenly spread, lies in a box: 0..1.   [own]"""
    return (k + 1) / (count + 1)


def planes_at(low, high, fraction):
    """The planes [..., 3] across x, y and z at a fraction [...] of a box.   [own]"""
    return low + fraction[..., None] * (np.asarray(high, float) - low)


def plane_costs(low, high, fraction, left, right):
    """[..., 3]: N_left A_left + N_right A_right of the planes of `planes_at`, A half the area of a part.   [Mat 6]

    left, right : [..., 3] references on both sides, for each axis
    """
    e = np.asarray(high, float) - low
    b, c = np.roll(e, -1, -1), np.roll(e, -2, -1)
    x = fraction[..., None] * e
    return np.where(e > 0, left * (b * c + (b + c) * x) + right * (b * c + (b + c) * (e - x)), 3e38)


def least_axis(v):
    """The unit vector [..., 3] of the axis along which v is least.   [own]"""
    return np.eye(3)[np.asarray(v).argmin(-1)]


def side_counts(low, high, planes):
    """1 for left plus 65536 for right, [..., 3], of the planes across x, y and z through a point.   [own]"""
    each = [
        np.concatenate([np.broadcast_to(n, np.shape(planes)), planes[..., i : i + 1]], -1)
        for i, n in enumerate(np.eye(3))
    ]
    left, right = (np.stack([sides(low, high, plane)[..., k] for plane in each], -1) for k in (0, 1))
    return left + 65536 * right


def gap_plane(cell_low, cell_high, low, high, share):
    """(+-unit vector, plane) [..., 4] that cuts off the widest empty side; zero if none.   [Zhou 2008, section 3.1]"""
    extent = np.maximum(np.asarray(cell_high, float) - cell_low, 1e-30)
    below, above = (low - cell_low) / extent, (cell_high - high) / extent
    # First the axis, x before y before z; then the low side before the high one.
    axis = np.maximum(below, above).argmax(-1)[..., None]
    b, a = (np.take_along_axis(x, axis, -1) for x in (below, above))
    l, h = (np.take_along_axis(np.asarray(x, float), axis, -1) for x in (low, high))
    n = np.eye(3)[axis[..., 0]]
    plane = np.concatenate([np.where(b >= a, n, -n), np.where(b >= a, l, h)], -1)
    return np.where(np.maximum(a, b) > np.asarray(share)[..., None], plane, 0.0)


def sides(low, high, plane):
    """(left, right) [..., 2], 0 or 1: which children boxes belong to.   [own]"""
    n, p = plane[..., :3], plane[..., 3]
    right = np.sum(high * n, -1) > p
    left = (np.sum(low * n, -1) < p) | ~right
    return np.stack([left, right], -1).astype(float)
