"""Directions spread evenly on a Fibonacci spiral (Swinbank and Purser 2006), in float64."""

import numpy as np


def golden_azimuth(n):
    """The azimuth at place n of the spiral: n golden angles."""
    return np.pi * (3.0 - np.sqrt(5.0)) * n


def spiral(n, r, z):
    """Directions [N, 3] at places n, a distance r from the axis and a height z."""
    phi = golden_azimuth(n)
    return np.stack([r * np.cos(phi), r * np.sin(phi), z], -1)


def even_directions(count):
    """Directions [count, 3] over the upper hemisphere, even in solid angle."""
    n = np.arange(count) + 0.5
    z = 1.0 - n / count
    return spiral(n, np.sqrt(1.0 - z * z), z)


def cosine_directions(count):
    """Directions [count, 3] over the upper hemisphere, even in cosine-weighted solid angle."""
    n = np.arange(count) + 0.5
    r = np.sqrt(n / count)
    return spiral(n, r, np.sqrt(1.0 - r * r))
