"""Twin of glsl/trace/sun_disc.glsl: points of a sun, which is a disc far away, in float64."""

import numpy as np


def disc_point(n, count, turn):
    """Point [..., 2] number n of `count` spread evenly over the unit disk, turned by `turn` of a whole turn.   [own]"""
    n, count, turn = np.asarray(n), np.asarray(count), np.asarray(turn, float)
    phi = 2.0 * np.pi * (np.modf(0.3819660112501051 * n)[0] + turn)
    return np.sqrt((n + 0.5) / count)[..., None] * np.stack([np.cos(phi), np.sin(phi)], -1)


def disc_direction(middle, tan_radius, at):
    """The direction [..., 3] toward a point [..., 2] of a disc of angular radius atan(tan_radius) about `middle`.   [own]"""
    middle, at, tan_radius = np.asarray(middle, float), np.asarray(at, float), np.asarray(tan_radius, float)[..., None]
    size = np.abs(middle)
    first = size[..., 0] <= np.minimum(size[..., 1], size[..., 2])
    axis = np.eye(3)[np.where(first, 0, np.where(size[..., 1] <= size[..., 2], 1, 2))]
    x = np.cross(axis, middle)
    x /= np.linalg.norm(x, axis=-1, keepdims=True)
    d = middle + tan_radius * (at[..., :1] * x + at[..., 1:] * np.cross(middle, x))
    return d / np.linalg.norm(d, axis=-1, keepdims=True)


def disc_above(middle, sin_radius):
    """(direction, share) [..., 4] of what the horizon z = 0 leaves of a disc about `middle` [..., 3]: toward the middle of
    that part, and how much of the disc it is.   [own]"""
    middle, sin_radius = np.asarray(middle, float), np.asarray(sin_radius, float)
    z = middle[..., 2]
    cos_2 = 1.0 - z * z
    whole = (np.abs(z) >= sin_radius) | (cos_2 < 1e-6)
    t = np.where(whole, 0.0, z / np.where(whole, 1.0, sin_radius))
    chord = np.sqrt(1.0 - t * t)
    share = 0.5 + (t * chord + np.arcsin(t)) / np.pi
    rise = sin_radius * np.minimum(2.0 / 3.0 * chord**3 / (np.pi * np.maximum(share, 1e-3)), 1.0)
    up = np.concatenate([-middle[..., :2] * z[..., None], cos_2[..., None]], -1)
    d = middle + (rise / np.sqrt(np.maximum(cos_2, 1e-6)))[..., None] * up
    d /= np.linalg.norm(d, axis=-1, keepdims=True)
    share = np.where(whole, np.where(z > 0.0, 1.0, 0.0), share)
    return np.concatenate([np.where(whole[..., None], middle, d), share[..., None]], -1)


def disc_directions(middle, radius, count):
    """Directions [count, 3] spread evenly over a disc about `middle` [3]."""
    return disc_direction(
        np.tile(middle, (count, 1)), np.full(count, np.tan(radius)), disc_point(np.arange(count), count, 0.0)
    )
