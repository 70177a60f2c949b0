"""Pictures that repeat over the UVs of cloth: what one repeat covers, and what stands at a place."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ..geometry.mesh import Mesh
from ..scene import ClothMap

MIDDLES = np.array([[2, 1, 1], [1, 2, 1], [1, 1, 2]]) / 4.0  # barycentric places in a triangle, one toward each corner,
FOUR_PLACES = np.concatenate([MIDDLES, np.full((1, 3), 1 / 3)])  # and its centre


def has_codes(path: str | Path) -> bool:
    """Whether the picture of a file holds codes of 8 or 16 bits, and not light."""
    return Path(path).suffix.lower() in (".png", ".jpg", ".jpeg")


def lie(entry: ClothMap, texels: np.ndarray) -> tuple[tuple[float, float], bool]:
    """How the picture [H, W, ...] of a map lies: what one repeat covers along u and v, and whether that is in metres and not in
    UV units."""
    in_metres = entry.unit == "m"
    height = entry.repeat * texels.shape[0] / texels.shape[1] if in_metres else entry.repeat
    return (entry.repeat, height), in_metres


def uv_places(mesh: Mesh, weights: np.ndarray) -> np.ndarray:
    """UVs [K, T, 2] at barycentric places [K, 3] of each triangle."""
    assert mesh.uv is not None
    return np.einsum("kc,tcd->ktd", weights, np.nan_to_num(np.asarray(mesh.uv, float))[mesh.triangles])


def texel_means(texels: np.ndarray, at: np.ndarray) -> np.ndarray:
    """Texels [H, W, C] of a picture that repeats, at places [..., 2] in repeats, linear between them: [..., C]."""
    height, width = texels.shape[:2]
    place = (at % 1.0) * (width, height) - 0.5
    low = np.floor(place).astype(int)
    x, y = np.moveaxis(place - low, -1, 0)[..., None]
    rows, columns = [(low[..., 1] + k) % height for k in (0, 1)], [(low[..., 0] + k) % width for k in (0, 1)]
    (a, b), (c, d) = [[texels[row, column] for column in columns] for row in rows]
    return (1 - y) * ((1 - x) * a + x * b) + y * ((1 - x) * c + x * d)
