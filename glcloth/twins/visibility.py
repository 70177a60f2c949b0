"""Visibility from probes on a sheet, in fixed directions of the world: the slow float64 twin of the passes
glsl/passes/visibility/*.comp."""

import numpy as np

from .directions import golden_azimuth, spiral


def reversed_bits(i, bits):
    """The number whose `bits` binary digits are those of i in reverse (van der Corput in base 2).   [own]"""
    i = np.asarray(i)
    return sum(((i >> n) & 1) << (bits - 1 - n) for n in range(bits))


def world_directions(count):
    """Directions [count, 3] of a Fibonacci spiral, ordered so that every beginning is spread evenly; count = 2^m.

    Swinbank and Purser 2006, "Fibonacci grids: a novel approach to global modelling".
    """
    i = reversed_bits(np.arange(count), int(count).bit_length() - 1)
    z = 1.0 - (2.0 * i + 1.0) / count
    return spiral(i + 0.5, np.sqrt(1.0 - z * z), z)


def flat_weight(cos_theta, steepness=8.0):
    """How much a direction counts by its cosine: cloth's f cos(theta) is nearly flat in it, and stops at the horizon; with
    `steepness` 1 it is a Lambertian's.   [own]"""
    return np.clip(steepness * np.asarray(cos_theta, float), 0.0, 1.0)


LEAST = 1e-4  # a Gaussian's tail below this counts as nothing


def gaussian_table(directions, axis, sharpness, count=None):
    """G [n, 1 + K] at n directions: 1, then exp(kappa (omega . xi - 1)) with kappa at most a quarter of `count` (default
    n): a narrower Gaussian would fall between so many directions; 0 where below LEAST.   [own]"""
    directions = np.asarray(directions, float)
    kappa = np.minimum(np.asarray(sharpness, float), (count or len(directions)) / 4.0)
    G = np.exp(kappa * (directions @ np.asarray(axis, float).reshape(-1, 3).T - 1.0))
    return np.concatenate([np.ones((len(directions), 1)), np.where(G < LEAST, 0.0, G)], 1)


def band_shares(z):
    """How much [..., 3] a direction of the cosine z belongs to the horizon, to the band above it (centred on 0.4) and to
    the top; hats that sum to 1.   [own]"""
    z = np.asarray(z, float)
    return np.stack([np.interp(z, [0.0, 0.4, 1.0], hat) for hat in np.eye(3)], -1)


def quadrant_shares(omega):
    """How much [..., 4] a direction of a surface frame belongs to +x, +y, -x, -y: the squares of cosine and sine of its
    azimuth; they sum to 1, but within 1e-6 of the pole.   [own]"""
    x, y = omega[..., 0], omega[..., 1]
    r_2 = np.maximum(x * x + y * y, 1e-12)
    return np.stack([np.maximum(v, 0.0) ** 2 / r_2 for v in (x, y, -x, -y)], -1)


def from_bands(omega, low, middle, top):
    """A value over the directions of a surface frame from its means toward +x, +y, -x, -y in two bands and at the top.   [own]"""
    bands = band_shares(omega[..., 2])
    ring = bands[..., :1] * np.asarray(low, float) + bands[..., 1:2] * np.asarray(middle, float)
    return np.sum(quadrant_shares(omega) * ring, -1) + bands[..., 2] * np.asarray(top, float)


def broad_sums(bits, N, x, handedness, directions, light):
    """Weights [P, 2, 2, 9] of the broad light that probes see and of all, front and back: low, middle, top.   [own]

    w_j = light_j min(8 |D_j . N|, 1) (share of the part)^2: squares, so that a mean is of the middle of its part.

    Parameters
    ----------
    bits : [P, n] bool
    N, x, handedness : [P, 3], [P, 3], [P] the probes' surface frames
    directions, light : [n, 3], [n]
    """
    y = np.asarray(handedness, float)[:, None] * np.cross(N, x)
    sums = []
    for sign in (1.0, -1.0):
        omega = np.stack([np.asarray(axis, float) @ np.asarray(directions, float).T for axis in (x, y, sign * N)], -1)
        bands, quadrants = band_shares(omega[..., 2]), quadrant_shares(omega)
        shares = np.concatenate([bands[..., :1] * quadrants, bands[..., 1:2] * quadrants, bands[..., 2:]], -1)
        w = (light * np.clip(8.0 * omega[..., 2], 0.0, 1.0))[..., None] * shares**2
        sums.append(np.stack([(w * bits[..., None]).sum(1), w.sum(1)], 1))
    return np.stack(sums, 1)


def own_directions(axis, sharpness, count):
    """Directions [count, 3], each for an equal share of a spherical Gaussian.   [own]"""
    n = np.arange(count) + 0.5
    kappa = max(float(sharpness), 1e-6)
    z = 1.0 + np.log1p(-(n / count) * -np.expm1(-2.0 * kappa)) / kappa
    phi = golden_azimuth(n)
    r = np.sqrt(np.maximum(1.0 - z * z, 0.0))
    axis = np.asarray(axis, float)
    u = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    u /= np.linalg.norm(u)
    return r[:, None] * (np.cos(phi)[:, None] * u + np.sin(phi)[:, None] * np.cross(axis, u)) + z[:, None] * axis


def mean_visibility(bits, N, directions, table, steepness=8.0):
    """V [P, 2, 1 + K]: the weighted share of the directions that each probe sees, front and back.   [own]

    V_k = (e_k + sum_j w_j G_kj V_j) / (e_k + sum_j w_j G_kj),   w_j = flat_weight(+-D_j . N),   e_k = LEAST sum_j G_kj:
    where a Gaussian lights the other side only, it goes to 1.

    Parameters
    ----------
    bits : [P, n] bool, V_j
    N : [P, 3]
    directions : [n, 3]
    table : [n, 1 + K] from `gaussian_table`
    steepness : of `flat_weight`
    """
    V = np.ones((len(N), 2, table.shape[1]))
    for side, sign in ((0, 1.0), (1, -1.0)):
        w = flat_weight(sign * (np.asarray(N, float) @ np.asarray(directions, float).T), steepness)
        below = w @ table
        above = (w * bits) @ table
        least = LEAST * table.sum(0)
        V[:, side] = (above + least) / np.maximum(below + least, 1e-30)
    return V


def response_to(cos_theta, flat_share):
    """What cloth gives back of a beam, over its albedo, on the side that the cosine is above 0 on and on the other
    [..., 2]: flat_share + (1 - 2 flat_share) z, the first term fading below z = 0.01. Even light gives the albedo.   [own]"""
    z = np.maximum(np.stack([np.asarray(cos_theta, float), -np.asarray(cos_theta, float)], -1), 0.0)
    flat_share = np.asarray(flat_share, float)[..., None]
    return flat_share * np.minimum(100.0 * z, 1.0) + (1.0 - 2.0 * flat_share) * z


def later_bounces(albedo, hidden):
    """All later bounces over the first, between surfaces like this one: 1 + (albedo hidden) + (albedo hidden)^2 + ...   [own]"""
    return 1.0 / (1.0 - np.clip(np.asarray(albedo, float) * np.asarray(hidden, float)[..., None], 0.0, 0.95))


def packed_sums(seen, all):
    """Words of the seen part and the whole (>= 0): its share in the low 16 bits, above it a cut float32.   [own]"""
    seen, all = np.asarray(seen, "f4"), np.asarray(all, "f4")
    share = np.where(all > 1e-30, seen / np.maximum(all, np.float32(1e-30)), np.float32(1.0))
    return (65535 * share + 0.5).astype("u4") | (all.view("u4") + np.uint32(0x8000) & np.uint32(0xFFFF0000))


def all_of_sums(sums):
    """The whole of such words.   [own]"""
    return (np.asarray(sums, "u4") & np.uint32(0xFFFF0000)).view("f4").astype(float)


def seen_of_sums(sums):
    """65535 times the seen part.   [own]"""
    return all_of_sums(sums) * (np.asarray(sums, "u4") & np.uint32(0xFFFF))
