"""Twin of glsl/trace/split.glsl: where a large node of the kd-tree is split, in float64."""

import numpy as np


def cheapest_middle(low, high, counts):
    """(unit vector of an axis, middle) [..., 4]: where halving a box costs least.   [own; Mat 6]

    counts : [..., 3] references in both halves, for each axis
    """
    e = np.asarray(high, float) - low
    b, c = np.roll(e, -1, -1), np.roll(e, -2, -1)
    cost = np.where(e > 0, counts * (b * c + (b + c) * e / 2), 3e38)
    n = np.eye(3)[cost.argmin(-1)]
    return np.concatenate([n, np.sum(n * 0.5 * (low + high), -1, keepdims=True)], -1)


def sides_of_middle(low, high, middle):
    """(left, right) [..., 2, 3], 0 or 1, of the planes across x, y and z through a point.   [own]"""
    planes = [
        np.concatenate([np.broadcast_to(n, np.shape(middle)), middle[..., i : i + 1]], -1)
        for i, n in enumerate(np.eye(3))
    ]
    return np.stack([sides(low, high, plane) for plane in planes], -1)


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
