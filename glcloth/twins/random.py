"""Twin of glsl/trace/random.glsl: hashes, and directions drawn with them, in float64."""

import numpy as np


def unit_square(hash):
    """Points [..., 2] of the unit square from hashes [..., 2] uint32, 24 bits each.   [own]"""
    return (np.asarray(hash, np.uint32) >> np.uint32(8)) / 2.0**24


def hash3(v):
    """Three hashes [..., 3] uint32 of three integers.   [Jarzynski and Olano 2020, pcg3d]"""
    v = np.asarray(v).astype(np.uint32)
    with np.errstate(over="ignore"):
        x, y, z = np.moveaxis(v * np.uint32(1664525) + np.uint32(1013904223), -1, 0)
        for turn in range(2):
            x = x + y * z
            y = y + z * x
            z = z + x * y
            if turn == 0:
                x, y, z = (a ^ (a >> np.uint32(16)) for a in (x, y, z))
    return np.stack([x, y, z], -1)


def cosine_direction(u):
    """Directions [..., 3] about +z distributed as their cosine, from u [..., 2].   [own]"""
    u = np.asarray(u, float)
    r, phi = np.sqrt(u[..., 0]), 2 * np.pi * u[..., 1]
    return np.stack([r * np.cos(phi), r * np.sin(phi), np.sqrt(1 - u[..., 0])], -1)


def facet_direction(u, roughness):
    """Facets [..., 3] distributed as D cos, from u [..., 2].   [Walter et al. 2007, Eq. 35-36]"""
    u = np.asarray(u, float)
    theta, phi = np.arctan(roughness * np.sqrt(u[..., 0] / (1 - u[..., 0]))), 2 * np.pi * u[..., 1]
    return np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], -1)
