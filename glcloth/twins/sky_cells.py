"""Twin of glsl/trace/sky_cells.glsl: the sphere in cells of an equirectangular map, in float64."""

import numpy as np


def cell_direction(cell, width, height, place):
    """The direction [..., 3] at a place [..., 2] in a cell; equal areas of it are equal solid angles.   [own]"""
    place = np.asarray(place, float)
    row, column = np.divmod(cell, width)
    upper, lower = np.cos(np.pi * row / height), np.cos(np.pi * (row + 1) / height)
    y = upper + place[..., 1] * (lower - upper)
    s, phi = np.sqrt(np.maximum(1 - y * y, 0)), 2 * np.pi * (column + place[..., 0]) / width
    return np.stack([s * np.sin(phi), y, -s * np.cos(phi)], -1)
