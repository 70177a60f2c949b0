"""Twin of glsl/trace/random.glsl: hashes, points that fill the unit interval, directions drawn with them, in float64."""

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


def _reversed(bits):
    """The 32 bits in the other order."""
    bits = np.asarray(bits, np.uint32)
    out = np.zeros_like(bits)
    for k in range(32):
        out |= ((bits >> np.uint32(k)) & np.uint32(1)) << np.uint32(31 - k)
    return out


def owen_scrambled(index, seed):
    """Points uint32 of van der Corput's sequence, scrambled as Owen does.   [Burley 2020; constants of Vegdahl 2021]"""
    x, seed = np.asarray(index).astype(np.uint32), np.asarray(seed).astype(np.uint32)
    with np.errstate(over="ignore"):
        x = x ^ (x * np.uint32(0x3D20ADEA))
        x = (x + seed) * ((seed >> np.uint32(16)) | np.uint32(1))
        x = x ^ (x * np.uint32(0x05526C56))
        x = x ^ (x * np.uint32(0x53A22864))
    return _reversed(x)


def second_index(index):
    """The index whose van der Corput point is that of `index` in Sobol's second dimension: bit m is the sum mod 2 of the
    bits j of `index` times the binomial coefficients (j over m).   [Sobol 1967]"""
    index = np.asarray(index).astype(np.uint32)
    out = np.zeros_like(index)
    for m in range(32):
        for j in range(m, 32):
            out ^= ((index >> np.uint32(j)) & np.uint32(j & m == m)) << np.uint32(m)  # Lucas: odd where j holds m
    return out


def stratified(index, key):
    """Samples [..., 3] of sequences `key` [..., 3] uint32 at `index`: x and y fill the square, and z the interval.

    [Burley 2020, section 5]
    """
    x, y, z = np.moveaxis(np.asarray(key).astype(np.uint32), -1, 0)
    u, v, _ = np.moveaxis(hash3(key), -1, 0)
    i, j = (owen_scrambled(_reversed(np.asarray(index).astype(np.uint32)), seed) for seed in (x, u))
    at = np.stack([owen_scrambled(i, y), owen_scrambled(second_index(i), z), owen_scrambled(j, v)], -1)
    return (at >> np.uint32(8)) / 2.0**24


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
