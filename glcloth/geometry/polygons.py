"""Polygons cut into triangles: convex ones into fans, others by ears."""

from __future__ import annotations

import mapbox_earcut
import numpy as np


def triangulate(positions: np.ndarray, corners: np.ndarray, counts: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Cut simple polygons, plane or nearly so, into triangles that all face their polygon's side.

    Holes may be joined to the rim by a pair of bridge edges.

    Parameters
    ----------
    positions : [V, 3]
    corners : [C] vertices of all polygons, one after the other
    counts : [P] corners of each polygon, 3 or more

    Returns the triangles as numbers of corners, [T, 3], in the order of the polygons, and the polygon of each, [T].
    """
    begins = np.cumsum(counts) - counts
    sizes = np.unique(counts)
    if sizes.tolist() == [3]:
        return np.arange(len(corners)).reshape(-1, 3), np.arange(len(counts))
    triangles, owners = [], []
    for size in sizes.tolist():
        which = np.flatnonzero(counts == size)
        index = begins[which][:, None] + np.arange(size)
        fans = np.stack([np.stack([index[:, 0], index[:, i], index[:, i + 1]], 1) for i in range(1, size - 1)], 1)
        if size == 3:
            cut, owner = fans[:, 0], which
        else:
            at = positions[corners[index]]
            convex = _strictly_convex(at)
            cut, owner = fans[convex].reshape(-1, 3), np.repeat(which[convex], size - 2)
            if not convex.all():
                others = np.flatnonzero(~convex)
                pieces = _quads(at[others], index[others]) if size == 4 else _by_ears(at[others], index[others])
                cut = np.concatenate([cut, *pieces])
                owner = np.concatenate([owner, np.repeat(which[others], [len(piece) for piece in pieces])])
        triangles.append(cut)
        owners.append(owner)
    owner = np.concatenate(owners)
    order = np.argsort(owner, kind="stable")
    return np.concatenate(triangles)[order], owner[order]


def _corner_normals(at: np.ndarray) -> np.ndarray:
    """Twice the signed area [P, n] at each corner of polygons [P, n, 3], against the normal of the whole (Newell's)."""
    ahead = np.roll(at, -1, 1) - at
    behind = np.roll(ahead, 1, 1)
    around = at - at[:, :1]
    normal = np.cross(around, np.roll(around, -1, 1)).sum(1)
    return np.einsum("pni,pi->pn", np.cross(behind, ahead), normal)


def _strictly_convex(at: np.ndarray) -> np.ndarray:
    """Whether all corners [P] of polygons [P, n, 3] are convex, and the fan about the first is without slivers."""
    with np.errstate(all="ignore"):
        turn = _corner_normals(at)
        largest = np.abs(turn).max(1, keepdims=True)
        # A star winds twice about its middle: then the corners turn by more than a whole turn.
        edge = np.roll(at, -1, 1) - at
        edge /= np.maximum(np.linalg.norm(edge, axis=2, keepdims=True), 1e-300)
        bend = np.arccos(np.clip(np.sum(edge * np.roll(edge, 1, 1), 2), -1, 1)).sum(1)
        # Not-a-number makes a fan: what is wrong with it is said later.
        return ~((turn <= 1e-7 * largest).any(1)) & ((bend < 3 * np.pi) | np.isnan(bend))


def _quads(at: np.ndarray, index: np.ndarray) -> list[np.ndarray]:
    """The triangles of quadrilaterals [P, 4, 3] with a reflex or straight corner: the better diagonal of the two."""
    turn = np.nan_to_num(_corner_normals(at))
    # A diagonal from 0 to 2 cuts off corners 1 and 3.
    first = np.minimum(turn[:, 1], turn[:, 3]) >= np.minimum(turn[:, 0], turn[:, 2])
    a = np.stack([index[:, [0, 1, 2]], index[:, [0, 2, 3]]], 1)
    b = np.stack([index[:, [1, 2, 3]], index[:, [1, 3, 0]]], 1)
    return list(np.where(first[:, None, None], a, b))


def _by_ears(at: np.ndarray, index: np.ndarray) -> list[np.ndarray]:
    """The triangles of polygons [P, n, 3], each seen along its normal; fans where that finds none."""
    found = []
    for polygon, corner in zip(at, index, strict=True):
        around = polygon - polygon[0]
        normal = np.cross(around, np.roll(around, -1, 0)).sum(0)
        axis = int(np.argmax(np.abs(normal)))
        # Two of the axes, so that the polygon is counter-clockwise.
        plane = np.delete(around, axis, 1)
        if (normal[axis] < 0) != (axis == 1):
            plane = plane[:, ::-1]
        cut = np.zeros((0, 3), np.int64)
        if np.isfinite(plane).all() and normal.any():
            ring = np.array([len(plane)], np.uint32)
            cut = mapbox_earcut.triangulate_float64(np.ascontiguousarray(plane), ring).astype(np.int64).reshape(-1, 3)
        if not len(cut):
            i = np.arange(1, len(corner) - 1)
            cut = np.stack([np.zeros_like(i), i, i + 1], 1)
        a, b, c = (plane[cut[:, k]] for k in range(3))
        area = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
        found.append(corner[np.where((area < 0)[:, None], cut[:, ::-1], cut)])
    return found
