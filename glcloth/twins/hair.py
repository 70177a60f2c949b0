"""Twin of glsl/fibre/hair.glsl: a hair that stands out from cloth, in float64."""

import numpy as np


def hair_place(way, bend, s):
    """Where a hair is [..., 3], in its lengths: in the surface frame.   [own]"""
    way, bend, s = np.asarray(way, float), np.asarray(bend, float), np.asarray(s, float)[..., None]
    turn, up = 2 * np.pi * way[..., 0], 0.12 + 0.83 * way[..., 1]
    out_by = np.sqrt(1 - up * up)
    first = np.stack([out_by * np.cos(turn), out_by * np.sin(turn), up], -1)
    second = np.stack([1.3 * (bend[..., 0] - 0.5), 1.3 * (bend[..., 1] - 0.5), -0.75 * way[..., 2] * up], -1)
    third = np.stack([1.1 * (bend[..., 2] - 0.5), 1.1 * (bend[..., 3] - 0.5), 0.45 * (way[..., 3] - 0.5)], -1)
    place = s * (first + s * (second + s * third))
    place[..., 2] = np.maximum(place[..., 2], 0.02 * s[..., 0])
    return place


def hair_cover(x, width):
    """The share of a pixel that a straight line covers.   [own]"""
    return np.clip(0.5 * width + 0.5 - np.abs(x), 0, np.minimum(width, 1))


def hair_horizon(N, omega, soft):
    """How much of the light from omega reaches a hair on cloth of normal N.   [own]"""
    t = np.clip(((np.asarray(N) * omega).sum(-1) + soft) / (2 * soft), 0, 1)
    return t * t * (3 - 2 * t)
