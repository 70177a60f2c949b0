"""Meshes with closed forms: positions, triangles, UVs in metres of cloth, and exact normals. +Y is up."""

from __future__ import annotations

import numpy as np

Arrays = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]


def grid_triangles(rows: int, columns: int) -> np.ndarray:
    """Return [2 (rows - 1) (columns - 1), 3] int32 triangles of a grid whose vertex (i, j) is i * columns + j.

    Counter-clockwise where x grows with j and y falls with i. Diagonals alternate like a chequerboard, so that the
    mesh has no preferred bending direction.
    """
    i, j = np.meshgrid(np.arange(rows - 1), np.arange(columns - 1), indexing="ij")
    a = (i * columns + j).ravel()
    b, c, d = a + 1, a + columns, a + columns + 1
    even = ((i + j) % 2 == 0).ravel()[:, None]
    one = np.where(even, np.column_stack([a, c, d]), np.column_stack([a, c, b]))
    two = np.where(even, np.column_stack([a, d, b]), np.column_stack([b, c, d]))
    return np.stack([one, two], axis=1).reshape(-1, 3).astype(np.int32)


def _grid(u: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the flattened grid of u (along a row) and v (down the rows)."""
    V, U = np.meshgrid(v, u, indexing="ij")
    return U.ravel(), V.ravel()


def plane(size: float = 1.0, divisions: int = 32) -> Arrays:
    """Return a flat square patch in the plane z = 0, facing +Z, yarn 1 along +X."""
    u, v = _grid(np.linspace(0, size, divisions + 1), np.linspace(size, 0, divisions + 1))
    positions = np.column_stack([u - size / 2, v - size / 2, np.zeros_like(u)])
    normals = np.broadcast_to([0.0, 0.0, 1.0], positions.shape)
    return positions, grid_triangles(divisions + 1, divisions + 1), np.column_stack([u, v]), normals


def sphere(radius: float = 0.5, parallels: int = 96, meridians: int = 192) -> Arrays:
    """Return a sphere about the origin with its poles at +-Y; yarn 1 runs along the parallels (eastward)."""
    u, v = _grid(np.linspace(0, 1, meridians + 1), np.linspace(1, 0, parallels + 1))
    longitude, latitude = 2 * np.pi * u, np.pi * (v - 0.5)
    cosine = np.cos(latitude)
    # Exactly one longitude at both ends of the seam, so that the two rims coincide bit for bit.
    normals = np.column_stack([cosine * np.sin(longitude % (2 * np.pi)), np.sin(latitude), cosine * np.cos(longitude)])
    uv = np.column_stack([u * 2 * np.pi * radius, v * np.pi * radius])
    return radius * normals, grid_triangles(parallels + 1, meridians + 1), uv, normals


def cylinder(radius: float = 0.5, height: float = 1.0, rings: int = 48, sectors: int = 192) -> Arrays:
    """Return an open cylinder about the Y axis; yarn 1 runs round it, yarn 2 up."""
    u, v = _grid(np.linspace(0, 1, sectors + 1), np.linspace(1, 0, rings + 1))
    angle = 2 * np.pi * (u % 1.0)
    normals = np.column_stack([np.sin(angle), np.zeros_like(angle), np.cos(angle)])
    positions = radius * normals + np.outer((v - 0.5) * height, [0.0, 1.0, 0.0])
    return (
        positions,
        grid_triangles(rings + 1, sectors + 1),
        np.column_stack([u * 2 * np.pi * radius, v * height]),
        normals,
    )


def rings(radii: np.ndarray, sectors: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return positions, triangles and normals of a disc in the plane y = 0 that faces +Y: its middle, then `sectors`
    vertices on each ring, from +Z toward +X."""
    angle = 2 * np.pi * np.arange(sectors) / sectors
    circle = np.column_stack([np.sin(angle), np.zeros(sectors), np.cos(angle)])
    positions = np.concatenate([np.zeros((1, 3)), (np.asarray(radii)[:, None, None] * circle).reshape(-1, 3)])
    s = np.arange(sectors)
    after = (s + 1) % sectors
    fan = np.column_stack([np.zeros(sectors, int), 1 + s, 1 + after])
    first = 1 + sectors * np.arange(len(radii) - 1)[:, None]
    a, b, c, d = (first + k for k in (s, after, s + sectors, after + sectors))
    bands = np.stack([np.stack([a, c, d], -1), np.stack([a, d, b], -1)], 2).reshape(-1, 3)
    normals = np.tile([0.0, 1.0, 0.0], (len(positions), 1))
    return positions, np.concatenate([fan, bands]).astype(np.int32), normals


def rounded_box(center, half_size, rounding: float, spacing: float, arc: int = 4) -> tuple[np.ndarray, ...]:
    """Return positions, triangles and normals of a box with rounded edges, its faces in squares of about `spacing` and a
    quarter round in 2 `arc` steps; `half_size` holds the rounding."""
    inner = np.asarray(half_size, float) - rounding
    positions, triangles, normals, count = [], [], [], 0
    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        # Beyond the flat part the face goes on to the middle of the round edge, 45 degrees.
        edge = rounding * np.tan(np.radians(np.linspace(0.0, 45.0, arc + 1)[1:]))
        a, b = (
            np.concatenate(
                [
                    -half - edge[::-1],
                    np.linspace(-half, half, max(2, int(np.ceil(2 * half / spacing)) + 1)),
                    half + edge,
                ]
            )
            for half in (inner[u], inner[v])
        )
        A, B = np.meshgrid(a, b)
        for side in (1.0, -1.0):
            p = np.empty((A.size, 3))
            p[:, axis], p[:, u], p[:, v] = side * (inner[axis] + rounding), A.ravel(), B.ravel()
            nearest = np.clip(p, -inner, inner)
            N = (p - nearest) / np.linalg.norm(p - nearest, axis=1, keepdims=True)
            grid = grid_triangles(len(b), len(a))
            positions.append(nearest + rounding * N + center)
            normals.append(N)
            # Rows grow with v here, where grid_triangles has them fall.
            triangles.append((grid[:, ::-1] if side > 0 else grid) + count)
            count += A.size
    return np.concatenate(positions), np.concatenate(triangles).astype(np.int32), np.concatenate(normals)
