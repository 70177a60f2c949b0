"""Coarse meshes made smooth: each triangle cut into four, vertices moved as Loop has them.   [Loop 1987; rims of Hoppe 1994]"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from .coincident import distinct
from .mesh import Mesh, assembled
from .raw import RawMesh, check_counts

CORNER = -0.7  # cosine between the two edges of a rim: above it they make a corner, which stays
PAIRS = ((0, 1), (1, 2), (2, 0))


def smoothed(mesh: Mesh, times: int) -> Mesh:
    """A mesh whose triangles were cut into four so many times, on the smooth surface that they approximate.

    Rims are smooth curves of their own; their corners, and edges of more than two triangles, stay. Seams of UVs stay closed,
    UVs are linear in each triangle. Normals are those of the new surface. Raises InputError for too many triangles.
    """
    if times == 0:
        return mesh
    check_counts(f"subdivide {times}: mesh {mesh.name}", triangles=len(mesh.triangles) << 2 * times)
    raw = RawMesh(
        np.asarray(mesh.positions, float), np.asarray(mesh.triangles, np.int64),
        None if mesh.uv is None else np.asarray(mesh.uv, float), None, mesh.parts, mesh.part_of,
    )  # fmt: skip
    for _ in range(times):
        raw = _cut(raw)
    made = assembled(raw, mesh.name, mesh.name)[0]
    # `assembled` may move a mesh to the origin; this one is there already.
    shift = np.asarray(made.origin, float)
    if shift.any():
        made = replace(made, positions=(made.positions + shift).astype(np.float32))
    return replace(made, origin=mesh.origin, scale=mesh.scale)


def _cut(raw: RawMesh) -> RawMesh:
    """One step. Vertices at one place, as along a seam of UVs, are one to the surface."""
    first, place = distinct(raw.positions)
    at, corners = raw.positions[first], raw.triangles
    edges, edge_of, shared = _edges(place[corners])
    opposite = np.stack([place[corners[:, 3 - sum(pair)]] for pair in PAIRS], 1)
    ends = at[edges]
    inner = shared == 2
    sums = np.stack([np.bincount(edge_of.ravel(), at[opposite.ravel(), k], len(edges)) for k in range(3)], 1)
    middles = np.where(inner[:, None], 0.375 * ends.sum(1) + 0.125 * sums, 0.5 * ends.sum(1))
    moved = _moved(at, edges, inner)
    # The vertices as they are stored, one more for each of their edges.
    own_edges, own_edge_of, _ = _edges(corners)
    surface_edge = np.empty(len(own_edges), np.int64)
    surface_edge[own_edge_of.ravel()] = edge_of.ravel()
    m = len(raw.positions) + own_edge_of
    c = corners
    parts = [
        (c[:, 0], m[:, 0], m[:, 2]), (m[:, 0], c[:, 1], m[:, 1]), (m[:, 2], m[:, 1], c[:, 2]), (m[:, 0], m[:, 1], m[:, 2]),
    ]  # fmt: skip
    triangles = np.stack([np.stack(part, 1) for part in parts], 1).reshape(-1, 3)
    uv = None if raw.uv is None else np.concatenate([raw.uv, raw.uv[own_edges].mean(1)])
    part_of = None if raw.part_of is None else np.repeat(raw.part_of, 4)
    positions = np.concatenate([moved[place], middles[surface_edge]])
    return replace(raw, positions=positions, triangles=triangles, uv=uv, part_of=part_of)


def _edges(corners: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Edges [E, 2] of triangles, each once; the number of each triangle's [T, 3]; how many triangles each has [E]."""
    pairs = np.sort(np.stack([corners[:, pair] for pair in PAIRS], 1).reshape(-1, 2), 1)
    keys, number, shared = np.unique(pairs[:, 0] << 32 | pairs[:, 1], return_inverse=True, return_counts=True)
    return np.stack([keys >> 32, keys & 0xFFFFFFFF], 1), number.reshape(-1, 3), shared


def _moved(at: np.ndarray, edges: np.ndarray, inner: np.ndarray) -> np.ndarray:
    """The places [V, 3] of the old vertices; those of a rim, of corners and of edges between more triangles apart."""
    count = len(at)

    def around(which: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        a, b = edges[which].T
        n = np.bincount(np.concatenate([a, b]), minlength=count)
        ends, others = np.concatenate([a, b]), np.concatenate([b, a])
        return n, np.stack([np.bincount(ends, at[others, k], count) for k in range(3)], 1)

    n, total = around(np.ones(len(edges), bool))
    on_rim, rim_total = around(~inner)
    n_least = np.maximum(n, 1)
    beta = ((0.625 - (0.375 + 0.25 * np.cos(2.0 * np.pi / n_least)) ** 2) / n_least)[:, None]
    smooth = (1.0 - n[:, None] * beta) * at + beta * total
    rim = 0.75 * at + 0.125 * rim_total
    # Of the two edges of a rim a, b: |a + b|^2 = |a|^2 + |b|^2 + 2 a b.
    a, b = edges[~inner].T
    squares = np.bincount(np.concatenate([a, b]), np.tile(((at[a] - at[b]) ** 2).sum(1), 2), count)
    both = rim_total - on_rim[:, None] * at
    cosine = ((both**2).sum(1) - squares) / np.maximum(squares, 1e-30)
    out = np.where((on_rim == 2)[:, None], rim, np.where((on_rim == 0)[:, None], smooth, at))
    return np.where(((on_rim == 2) & (cosine > CORNER))[:, None], at, out)
