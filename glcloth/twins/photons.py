"""Twin of glsl/trace/photons.glsl: where photons begin, and what their density says of the light, in float64."""

import numpy as np

CLOSE = 0.02
BENT = 0.1
NEVER = 3e38


def shifted_hammersley(i, count, shift):
    """Points [..., 2] of the unit square: number i of `count` evenly spread ones, shifted.   [Hammersley 1960]"""
    i = np.asarray(i, np.uint32)
    bits = np.zeros(i.shape, np.uint32)
    for k in range(32):
        bits |= ((i >> np.uint32(k)) & np.uint32(1)) << np.uint32(31 - k)
    even = np.stack([(i + 0.5) / np.asarray(count, float), (bits >> np.uint32(8)) / 2.0**24], -1)
    return np.mod(even + shift, 1.0)


def disc_distance(way, n):
    """Squared distances of points of a surface with the normal n; NEVER where they do not lie on the same one.   [own]"""
    way = np.asarray(way, float)
    d2, off = (way * way).sum(-1), np.abs((way * n).sum(-1))
    return np.where((off <= CLOSE) | (off**2 <= BENT**2 * d2), d2, NEVER)


def disc_kernel(d2, r2):
    """What photons at squared distances count for in discs of squared radius r2.   [Silverman 1986, Epanechnikov]"""
    return np.maximum(1.0 - np.asarray(d2, float) / r2, 0.0)


def cut_share(p, a, b, n, r):
    """The share of the area of discs of radius r about p, by their kernel, that edges from a to b cut off.   [own]"""
    p, a, b, n = (np.asarray(v, float) for v in (p, a, b, n))
    r = np.asarray(r, float)
    along = (b - a) / np.linalg.norm(b - a, axis=-1, keepdims=True)
    h = (np.cross(n, along) * (p - a)).sum(-1) / r
    reach = np.sqrt(np.maximum(1.0 - h * h, 0.0))
    sums = []
    for end in (a, b):
        x = np.clip(((end - p) * along).sum(-1) / r, -reach, reach)
        angle = np.where(h < 0, -1.0, 1.0) * np.arctan2(x, np.maximum(np.abs(h), 1e-7))
        sums.append(angle + x * h * (h * h - 2.0 + x * x / 3.0))
    return (sums[1] - sums[0]) / (2 * np.pi)
