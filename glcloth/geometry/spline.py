"""Cubic B-spline surfaces over the vertices of a simulated cloth, and the built-in meshes that are kept as such vertices."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np

from .mesh import Mesh, build_mesh
from .shapes import grid_triangles

LEVELS = 65535  # in which a stored coordinate is counted, from the least to the largest of all


def surface_mesh(name: str, positions: np.ndarray, size: tuple[float, float], rows: int, columns: int) -> Mesh:
    """Return the cubic B-spline surface over `positions` [R, C, 3] of a cloth of `size` (m), sampled rows x columns.

    The border curves are kept; inside, the surface lies within half a bending height of the vertices. UVs are metres,
    u along a row, v up the columns.
    """
    positions = np.asarray(positions, np.float64)
    by_row, by_row_slope = spline(positions.shape[0], rows)
    by_column, by_column_slope = spline(positions.shape[1], columns)

    def sample(a: np.ndarray, b: np.ndarray) -> np.ndarray:
        return np.einsum("ri,cj,ijk->rck", a, b, positions, optimize=True).reshape(-1, 3)

    # The same weights carry the flat cloth's coordinates, so the UVs are those of the material at each sample.
    u = by_column @ np.linspace(0.0, size[0], positions.shape[1])
    v = by_row @ np.linspace(size[1], 0.0, positions.shape[0])
    uv = np.stack(np.meshgrid(u, v), axis=-1).reshape(-1, 2)
    # v falls down the rows, hence the order of the factors.
    N = np.cross(sample(by_row_slope, by_column), sample(by_row, by_column_slope))
    return build_mesh(name, sample(by_row, by_column), grid_triangles(rows, columns), uv, N)


def spline(count: int, samples: int) -> tuple[np.ndarray, np.ndarray]:
    """Return [samples, count] weights of a clamped uniform cubic B-spline's value and slope, evenly over its length."""
    from scipy.interpolate import BSpline  # a quarter of a second of its own

    knots = np.concatenate([[0.0] * 3, np.linspace(0.0, 1.0, count - 2), [1.0] * 3])
    basis = BSpline(knots, np.eye(count), 3)
    # The flat cloth's own coordinate is the spline of its vertices; invert it so that samples are even in cloth.
    fine = np.linspace(0.0, 1.0, 64 * samples)
    t = np.interp(np.linspace(0.0, 1.0, samples), basis(fine) @ np.linspace(0.0, 1.0, count), fine)
    return basis(t), basis.derivative()(t)


def packed(positions: np.ndarray, size: tuple[float, float]) -> bytes:
    """Vertices [R, C, 3] of a cloth of `size` (m), each coordinate in two bytes: some hundredths of a millimetre."""
    low, high = positions.min((0, 1)).astype("f8"), positions.max((0, 1)).astype("f8")
    levels = np.round((positions - low) / np.maximum(high - low, 1e-9) * LEVELS).astype("<u2")
    # Differences from row to row are small numbers, which pack well.
    steps = np.diff(levels.astype("i4"), axis=0, prepend=0).astype("<u2")
    blob = io.BytesIO()
    np.savez_compressed(blob, steps=steps, low=low, high=high, size=np.array(size, "f8"))
    return blob.getvalue()


def unpacked(path: Path) -> tuple[np.ndarray, tuple[float, float]]:
    """What `packed` packed: positions [R, C, 3] float64 and the size."""
    with np.load(path) as data:
        levels = np.cumsum(data["steps"].astype("u2"), axis=0, dtype="u2").astype(float)
        positions = data["low"] + levels / LEVELS * (data["high"] - data["low"])
        width, height = data["size"].tolist()
    return positions, (width, height)
