"""The rims of a room's surfaces, where they end: photons lie on one side of them alone, which an estimate must know."""

from __future__ import annotations

from dataclasses import dataclass

import moderngl
import numpy as np
from scipy.spatial import cKDTree

from ..accel.queries import RayQueries
from ..accel.structure import Structure
from ..progress import track
from ..twins.photons import CLOSE

STEP = 0.03  # m, along an edge between two questions whether the surface goes on beyond it
MOST_STEPS = 256  # of an edge
MOST_QUESTIONS = 2_000_000  # of all edges, beside one each
BEYOND = 0.002  # m, past an edge
AGREE = 0.7  # cosine between normals of one surface, as of photons that count
FLAT = 0.95  # cosine from which on surfaces are as good as parallel
MOST = 24  # rims of a triangle: the nearest ones


@dataclass(frozen=True)
class Rims:
    """ends : [S, 2, 3], from where to where each goes, the surface on its left. lists : [2 T, 2] uint32: of each triangle, seen
    from the front and from behind, the first rim and how many."""

    ends: np.ndarray
    lists: np.ndarray

    def with_sheet(self, width: float, height: float, z: float, begin: float = 0.0) -> Rims:
        """And those of a flat cloth with two sides, at z and -z, from (begin, -height) to (begin + width, 0)."""
        x, y = begin + np.array([0.0, width, width, 0.0]), np.array([-height, -height, 0.0, 0.0])
        front = np.stack([x, y, np.full(4, z)], 1)
        front = np.stack([front, np.roll(front, -1, 0)], 1)
        back = front[:, ::-1] * [1.0, 1.0, -1.0]
        S = len(self.ends)
        return Rims(
            np.concatenate([self.ends, front, back]),
            np.concatenate([self.lists, np.array([[S, 4], [S + 4, 4]], np.uint32)]),
        )


def find_rims(ctx: moderngl.Context, positions: np.ndarray, structure: Structure, reach: float) -> Rims:
    """The rims of triangles [T, 3, 3] within `reach` of each. structure : built of the triangles."""
    corners = positions.astype(float)
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    size = np.linalg.norm(normals, axis=1)
    normals /= np.maximum(size, 1e-30)[:, None]
    ends, owner = _open_edges(ctx, corners, normals, size > 0, structure)
    T = len(corners)
    if not len(ends):
        return Rims(np.zeros((0, 2, 3)), np.zeros((2 * T, 2), np.uint32))
    lists, out, count = np.zeros((2 * T, 2), np.uint32), [], 0
    number = np.maximum(np.ceil(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1) / reach).astype(int), 1)
    rim = np.repeat(np.arange(len(ends)), number)
    share = (np.arange(len(rim)) - np.repeat(np.cumsum(number) - number, number) + 0.5) / number[rim]
    tree = cKDTree(ends[rim, 0] + share[:, None] * (ends[rim, 1] - ends[rim, 0]))
    middle = corners.mean(1)
    radius = np.linalg.norm(corners - middle[:, None], axis=2).max(1)
    for t in track(range(T), "photons: rims of the room", T):  # one at a time: the lists of all together have no bound
        found = np.unique(rim[tree.query_ball_point(middle[t], radius[t] + 1.5 * reach)])
        agree = normals[owner[found]] @ normals[t]
        off = np.abs((ends[found].mean(1) - middle[t]) @ normals[t])
        found = found[(agree > AGREE) & (off < np.where(agree > FLAT, CLOSE, 0.3 * reach))]
        if len(found) > MOST:
            way = np.linalg.norm(ends[found].mean(1) - middle[t], axis=1)
            found = found[np.argsort(way, kind="stable")[:MOST]]
        for side in (0, 1):
            lists[2 * t + side] = count, len(found)
            count += len(found)
            out.append(ends[found][:, ::-1] if side else ends[found])
    return Rims(np.concatenate(out), lists)


def _open_edges(
    ctx: moderngl.Context, corners: np.ndarray, normals: np.ndarray, there: np.ndarray, structure: Structure
) -> tuple[np.ndarray, np.ndarray]:
    """Parts of edges [S, 2, 3] beyond which no surface goes on, and their triangles [S]."""
    a = corners[there].reshape(-1, 3)
    b = np.roll(corners[there], -1, 1).reshape(-1, 3)
    triangle = np.repeat(np.flatnonzero(there), 3)
    length = np.linalg.norm(b - a, axis=1)
    step = max(STEP, length.sum() / MOST_QUESTIONS)
    steps = np.clip(np.ceil(length / step), 1, MOST_STEPS).astype(int)
    edge = np.repeat(np.arange(len(a)), steps)
    place = np.arange(len(edge)) - np.repeat(np.cumsum(steps) - steps, steps)
    n = normals[triangle[edge]]
    along = (b - a) / np.maximum(length, 1e-30)[:, None]
    outward = np.cross(along[edge], n)
    p = a[edge] + ((place + 0.5) / steps[edge])[:, None] * (b - a)[edge] + BEYOND * outward
    queries = RayQueries(ctx)
    hits = queries.closest_hit(structure, p + CLOSE * n, -n, 0.0, 2 * CLOSE)
    queries.release()
    agrees = np.abs((normals[np.maximum(hits.triangle, 0)] * n).sum(1)) > AGREE
    is_open = ~((hits.triangle >= 0) & agrees)
    # Runs of open steps of one edge.
    begins = is_open & np.concatenate([[True], ~is_open[:-1] | (edge[1:] != edge[:-1])])
    last = is_open & np.concatenate([~is_open[1:] | (edge[1:] != edge[:-1]), [True]])
    e = edge[begins]
    low, high = place[begins] / steps[e], (place[last] + 1) / steps[e]
    ends = np.stack([a[e] + low[:, None] * (b - a)[e], a[e] + high[:, None] * (b - a)[e]], 1)
    return ends, triangle[e]
