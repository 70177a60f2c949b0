"""Triangles that are none are dropped, and the others turned so that neighbours, and the file's normals, agree on a side."""

from __future__ import annotations

import numpy as np

from .coincident import all_differ, distinct
from .faces import dot, gathered


def dropped(place: np.ndarray, triangles: np.ndarray, area: np.ndarray) -> np.ndarray:
    """Return which triangles [K] stay of [T, 3]: those with an area [3, T], and of equal ones, either way round, the first.

    place : [V] equal for vertices at the same place; area: [3, T], the normal scaled by the area
    """
    solid = np.flatnonzero((area != 0).any(0))
    a, b, c = place[(triangles if len(solid) == len(triangles) else triangles[solid]).T]
    low, high = np.minimum(np.minimum(a, b), c), np.maximum(np.maximum(a, b), c)
    first, _ = distinct(np.stack([low, a + b + c - low - high, high], 1))
    return solid[np.sort(first)]


def turned(place: np.ndarray, triangles: np.ndarray, area: np.ndarray, normals: np.ndarray | None) -> np.ndarray:
    """Return which triangles [T] bool to turn over: first all that share edges get one side, that of the larger area;
    then each is turned to the side of its file's normals [V, 3], where it has some (not NaN, not 0).
    """
    known = np.zeros(len(triangles), bool)
    toward = np.zeros(len(triangles))
    if normals is not None:
        toward = dot(gathered(np.nan_to_num(normals, posinf=0.0, neginf=0.0), triangles).sum(0), area)
        known = toward != 0
    if known.all():
        return toward < 0
    return np.where(known, toward < 0, _against_neighbours(place[triangles], np.sqrt(dot(area, area))))


def _against_neighbours(corners: np.ndarray, area: np.ndarray) -> np.ndarray:
    """Which triangles [T, 3] lie the other way round than their neighbours over edges that two share."""
    count = len(corners)
    none = np.zeros(count, bool)
    start, end = corners.T.ravel(), np.roll(corners, -1, 1).T.ravel()  # corner k of triangle t is number k count + t
    most = np.int64(corners.max(initial=0)) + 1
    if all_differ(start * most + end):  # no edge is passed twice the same way
        return none
    key = np.minimum(start, end) * most + np.maximum(start, end)
    order = np.argsort(key, kind="stable")
    key = key[order]
    fresh = np.concatenate([[True], key[1:] != key[:-1], [True]])
    begins = np.flatnonzero(fresh)
    pair = order[begins[:-1][np.diff(begins) == 2, None] + [0, 1]]
    a, b = (pair % count).T
    opposed = start[pair[:, 0]] == start[pair[:, 1]]
    if not opposed.any():
        return none
    from scipy import sparse
    from scipy.sparse import csgraph  # a fifth of a second of its own; most meshes are consistent

    # Node t is triangle t as it is, node count + t the same turned over: edges join those that agree.
    rows = np.concatenate([a, a + count])
    columns = np.concatenate([np.where(opposed, b + count, b), np.where(opposed, b, b + count)])
    graph = sparse.coo_array((np.ones(len(rows), np.int8), (rows, columns)), shape=(2 * count, 2 * count))
    groups, label = csgraph.connected_components(graph, directed=False)
    as_it_is, over = label[:count], label[count:]
    weight = np.bincount(as_it_is, area, groups)
    flip = weight[over] > weight[as_it_is]
    flip |= (weight[over] == weight[as_it_is]) & (over < as_it_is)
    one_sided = as_it_is == over
    if one_sided.any():
        flip[one_sided] = _along_a_tree(one_sided, a, b, opposed)[one_sided]
    return flip


def _along_a_tree(one_sided: np.ndarray, a: np.ndarray, b: np.ndarray, opposed: np.ndarray) -> np.ndarray:
    """Which triangles [T] to turn in surfaces with one side only (a Moebius strip): all agree but over one cut."""
    from scipy import sparse
    from scipy.sparse import csgraph

    count = len(one_sided)
    value = np.where(opposed, 2, 1).astype(np.int8)
    graph = sparse.coo_array((value, (a, b)), shape=(count, count)).tocsr()
    graph = graph.maximum(graph.T).tocsr()
    flip, todo = np.zeros(count, bool), one_sided.copy()
    while todo.any():
        order, before = csgraph.breadth_first_order(graph, int(np.argmax(todo)), directed=False)
        step = np.asarray(graph[before[order[1:]], order[1:]]).ravel() == 2
        for node, turn in zip(order[1:].tolist(), step.tolist(), strict=True):
            flip[node] = flip[before[node]] != turn
        todo[order] = False
    return flip
