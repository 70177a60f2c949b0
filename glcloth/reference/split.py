"""Twin of glsl/trace/split.glsl: where a large node of the kd-tree is split, in float64."""

import numpy as np


def middle_plane(low, high):
    """(unit vector of the longest axis, its middle) [..., 4] of boxes.   [Zhou 2008, section 3.1]"""
    e = np.asarray(high, float) - low
    axis = np.where(e[..., 2] > np.maximum(e[..., 0], e[..., 1]), 2, np.where(e[..., 1] > e[..., 0], 1, 0))
    n = np.eye(3)[axis]
    return np.concatenate([n, np.sum(n * 0.5 * (low + high), -1, keepdims=True)], -1)


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
