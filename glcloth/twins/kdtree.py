"""An exact kd-tree by the surface area heuristic, on the CPU: the measure of the GPU's tree.

Every face of every clipped box is a candidate in every node, and triangles are clipped to their node.   [Wald, Havran
2006, "On building fast kd-trees for ray tracing"; Zhou 2008; paper B, Eq. 6]
"""

import numpy as np


def clip_polygons(polygon, low, high):
    """The parts [n, 9, 3] of convex polygons inside a box; unused corners are NaN.

    polygon : [n, 3, 3] triangles; low, high : [3]
    """
    n = len(polygon)
    points = np.full((n, 9, 3), np.nan)
    points[:, :3] = polygon
    count = np.full(n, 3)
    rows = np.arange(n)
    for axis in range(3):
        for side, plane in ((1.0, low[axis]), (-1.0, high[axis])):
            out, filled = np.full((n, 10, 3), np.nan), np.zeros(n, int)
            distance = side * (points[..., axis] - plane)
            for i in range(9):
                live = i < count
                after = np.where(i + 1 < count, i + 1, 0)
                d, e = distance[:, i], distance[rows, after]
                inside = live & (d >= 0)
                out[rows[inside], filled[inside]] = points[inside, i]
                filled += inside
                crosses = live & ((d < 0) != (e < 0))
                with np.errstate(invalid="ignore", divide="ignore"):
                    p = points[:, i] + (d / (d - e))[:, None] * (points[rows, after] - points[:, i])
                p[:, axis] = plane
                out[rows[crosses], filled[crosses]] = p[crosses]
                filled += crosses
            points, count = out[:, :9], filled
    return points


def best_split(boxes, low, high, C_ts):
    """(cost, axis, plane) of the cheapest plane strictly inside a node; cost = inf when there is none.   [Mat 6]

    boxes : [n, 2, 3] low and high corners of the triangles' parts
    """
    extent = high - low
    area = extent[0] * extent[1] + extent[1] * extent[2] + extent[2] * extent[0]
    best = (np.inf, 0, 0.0)
    for axis in range(3):
        begin, end = np.sort(boxes[:, 0, axis]), np.sort(boxes[:, 1, axis])
        flat = np.sort(boxes[boxes[:, 0, axis] == boxes[:, 1, axis], 0, axis])
        plane = np.unique(np.concatenate([begin, end]))
        plane = plane[(plane > low[axis]) & (plane < high[axis])]
        if len(plane) == 0:
            continue
        in_plane = np.searchsorted(flat, plane, "right") - np.searchsorted(flat, plane, "left")
        left = np.searchsorted(begin, plane, "left") + in_plane
        right = len(end) - np.searchsorted(end, plane, "right")
        b, c = extent[axis - 2], extent[axis - 1]
        x = plane - low[axis]
        cost = C_ts + (left * (b * c + (b + c) * x) + right * (b * c + (b + c) * (extent[axis] - x))) / area
        k = int(cost.argmin())
        if cost[k] < best[0]:
            best = float(cost[k]), axis, float(plane[k])
    return best


def build(triangles, C_ts=2.0, deepest=48):
    """The tree of triangles [T, 3, 3], or of sets of k triangles [T, k, 3, 3] that are one to the builder.

    axis [N] (3 = leaf), count [N], low, high [N, 3], depth [N].
    """
    triangles = np.asarray(triangles, float)
    triangles = triangles[:, None] if triangles.ndim == 3 else triangles
    root = np.stack([triangles.min((1, 2)), triangles.max((1, 2))], 1)
    nodes = []
    todo = [(np.arange(len(triangles)), root, root[:, 0].min(0), root[:, 1].max(0), 0)]
    while todo:
        index, boxes, low, high, depth = todo.pop()
        cost, axis, plane = best_split(boxes, low, high, C_ts) if len(index) > 1 and depth < deepest else (np.inf, 0, 0)
        if cost >= len(index):
            nodes.append((3, len(index), low, high, depth))
            continue
        nodes.append((axis, 0, low, high, depth))
        right = boxes[:, 1, axis] > plane
        left = (boxes[:, 0, axis] < plane) | ~right
        for chosen, is_left in ((right, False), (left, True)):
            child_low, child_high = low.copy(), high.copy()
            (child_high if is_left else child_low)[axis] = plane
            part, own = boxes[chosen].copy(), index[chosen]
            both = (left & right)[chosen]
            if both.any():
                polygons = triangles[own[both]]
                points = clip_polygons(polygons.reshape(-1, 3, 3), child_low, child_high)
                points = points.reshape(len(polygons), -1, 3)
                some = ~np.isnan(points[..., 0]).all(1)
                clipped = np.stack([np.fmin.reduce(points[some], 1), np.fmax.reduce(points[some], 1)], 1)
                rows = np.flatnonzero(both)
                part[rows[some]] = clipped
                keep = np.ones(len(own), bool)
                keep[rows[~some]] = False
                own, part = own[keep], part[keep]
            todo.append((own, part, child_low, child_high, depth + 1))
    axis, count, low, high, depth = (np.array(column) for column in zip(*nodes, strict=True))
    return {"axis": axis, "count": count, "low": low, "high": high, "depth": depth}


def sah_cost(tree, C_ts):
    """The expected cost of a ray through a tree, in triangle tests.   [Mat 6, over the whole tree]"""
    e = (tree["high"] - tree["low"]).astype(float)
    area = e[:, 0] * e[:, 1] + e[:, 1] * e[:, 2] + e[:, 2] * e[:, 0]
    leaf = tree["axis"] == 3
    return float((np.where(leaf, tree["count"], C_ts) * area).sum() / area[0])
