"""Large triangles cut finer the nearer they are to a cloth: what is lit at vertices needs some where the cloth's shadow is."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from .coincident import distinct
from .mesh import Mesh

LARGE = 2.0  # radii of the cloth: smaller objects are fine enough once they are cut evenly
FINE = 1 / 21  # of the cloth's radius: edges beside it, as those of the ground's rings
FARTHEST = 5_000.0  # radii of the cloth: what lies beyond is left out, for float32 knows one scale at a time
MOST_VERTICES = 12_000
LONG = 0.7  # of a triangle's longest edge: others as long are cut with it


@lru_cache(maxsize=16)
def graded(mesh: Mesh, center: tuple[float, float, float], radius: float) -> tuple[Mesh, np.ndarray]:
    """Return the same surface with edges of at most FINE (1 + d / (2 radius))^2 radii, or d, at a distance d from a cloth's
    centre, and the old triangle [T] of each new one.

    The mesh itself where it is no larger than the cloth, or fine enough. Edges are cut in their middle, in all triangles
    that share them, so that no gap opens.
    """
    source = np.arange(len(mesh.triangles))
    if mesh.radius <= LARGE * radius:
        return mesh, source
    # A map of 16 columns: everything that a middle takes the mean of.
    rows = np.column_stack([mesh.positions, mesh.normals, mesh.tangents[:, :3]]).astype(np.float64)
    uv = np.zeros((len(rows), 2)) if mesh.uv is None else mesh.uv.astype(np.float64)
    rows, sign, corners = np.column_stack([rows, uv]), mesh.tangents[:, 3], mesh.triangles.astype(np.int64)
    while len(rows) <= MOST_VERTICES:
        _, place = distinct(rows[:, :3])
        cut = _edges_to_cut(rows[:, :3], place, corners, np.array(center), radius)
        if not cut.any():
            break
        a, b = corners.T.ravel(), np.roll(corners, -1, 1).T.ravel()  # edge k of triangle t is number k T + t
        key = np.stack([np.minimum(a, b), np.maximum(a, b)], 1)
        where = np.flatnonzero(cut.T.ravel())
        first, group = distinct(key[where])
        ends = key[where[first]]
        middle = np.full(len(a), -1)
        middle[where] = len(rows) + group
        rows = np.vstack([rows, _unit_columns(0.5 * (rows[ends[:, 0]] + rows[ends[:, 1]]))])
        sign = np.concatenate([sign, sign[ends[:, 0]]])
        corners, source = _cut(corners, middle.reshape(3, -1).T, source)
    near = np.linalg.norm(_beside(rows[corners][..., :3], np.array(center)), axis=1) <= FARTHEST * radius
    if not near.any() or len(source) == len(mesh.triangles):
        return mesh, np.arange(len(mesh.triangles))
    if not near.all():
        used, corners = np.unique(corners[near], return_inverse=True)
        rows, sign, corners, source = rows[used], sign[used], corners.reshape(-1, 3), source[near]
    return Mesh(
        mesh.name,
        rows[:, :3],
        corners,
        rows[:, 3:6],
        None if mesh.uv is None else rows[:, 9:],
        np.column_stack([rows[:, 6:9], sign]),
        mesh.parts,
        None if mesh.part_of is None else mesh.part_of[source],
        mesh.origin,
    ), source


def _unit_columns(rows: np.ndarray) -> np.ndarray:
    """Rows whose normals and tangents have length 1 again."""
    for begin in (3, 6):
        v = rows[:, begin : begin + 3]
        rows[:, begin : begin + 3] = v / np.maximum(np.linalg.norm(v, axis=1, keepdims=True), 1e-12)
    return rows


def _edges_to_cut(
    positions: np.ndarray, place: np.ndarray, corners: np.ndarray, center: np.ndarray, radius: float
) -> np.ndarray:
    """Which edges [T, 3] are too long; an edge that one of its triangles finds so is so in all."""
    at = positions[corners]
    length = np.linalg.norm(np.roll(at, -1, 1) - at, axis=2)
    beside = _beside(at, center)
    distance = np.linalg.norm(beside, axis=1)
    allowed = np.minimum(FINE * radius * (1 + distance / (2 * radius)) ** 2, radius + distance)
    longest = length.max(1)
    cut = (length >= LONG * longest[:, None]) & (length > allowed[:, None])
    a, b = place[corners], place[np.roll(corners, -1, 1)]
    _, edge = distinct(np.stack([np.minimum(a, b), np.maximum(a, b)], 2).reshape(-1, 2))
    marked = np.zeros(edge.max() + 1, bool)
    marked[edge[cut.ravel()]] = True
    return marked[edge].reshape(cut.shape)


def _beside(at: np.ndarray, center: np.ndarray) -> np.ndarray:
    """From a point to the boxes of triangles [T, 3, 3], which are as near as these, or nearer; [T, 3]."""
    return np.maximum(np.maximum(at.min(1) - center, center - at.max(1)), 0.0)


def _cut(corners: np.ndarray, middle: np.ndarray, source: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Triangles [T, 3] cut at the middles of their edges ([T, 3] vertices, -1: not cut), each into one to four."""
    count = (middle >= 0).sum(1)
    pieces, owners = [corners[count == 0]], [np.flatnonzero(count == 0)]
    for n in (1, 2, 3):
        which = np.flatnonzero(count == n)
        # One cut: turned so that edge 0 is it. Two: so that edge 2 is the one that is whole.
        turn = middle[which].argmax(1) if n == 1 else (np.argmin(middle[which], 1) + 1) % 3 if n == 2 else 0 * which
        index = (turn[:, None] + np.arange(3)) % 3
        (a, b, c), (p, q, r) = (np.take_along_axis(v[which], index, 1).T for v in (corners, middle))
        split = {1: [(a, p, c), (p, b, c)], 2: [(p, b, q), (a, p, q), (a, q, c)],
                 3: [(a, p, r), (p, b, q), (r, q, c), (p, q, r)]}[n]  # fmt: skip
        pieces += [np.stack(piece, 1) for piece in split]
        owners += [which] * len(split)
    owner = np.concatenate(owners)
    order = np.argsort(owner, kind="stable")
    return np.concatenate(pieces)[order], source[owner[order]]
