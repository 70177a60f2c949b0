"""Where on a mesh its surroundings are looked at: its vertices, or more or fewer.   [own]"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy import sparse

from ..geometry.mesh import Mesh

MOST_PROBES = 32_000
MOST_VERTICES = 16_000  # by subdivision
# Up to so many probes each traces all directions, or a half, a quarter, an eighth; its neighbours know the others.
WHOLE, HALF, QUARTER = 6_000, 12_000, 32_000
CROWD = 8  # triangles for each vertex there may be
HUB = 1_000  # neighbours of a vertex
LONGEST_EDGE = 1 / 24  # of the mesh's radius: nobody knows which folds are wide enough for five vertices across
OFFSET = 0.06  # of a vertex's mean edge: how far rays start from it


@dataclass(frozen=True, eq=False)
class Probes:
    """Points of a sheet whose visibility is traced, and how the vertices of a mesh share it.

    Parameters
    ----------
    points, normals : [P, 3]
    tangents : [P, 4] yarn 1, and the handedness
    offset : [P, 2] how far off the front and the back rays start
    first : [C + 1] where each class of probes begins, and P; each class has its own share of the directions
    spread : [V, P] sparse; a row's weights sum to 1 in each class that it has
    vertices : [P] the vertex that each probe is
    """

    points: np.ndarray
    normals: np.ndarray
    tangents: np.ndarray
    offset: np.ndarray
    first: np.ndarray
    spread: sparse.csr_array
    vertices: np.ndarray

    def moved(self, mesh: Mesh) -> Probes:
        """The same probes after the vertices of the mesh moved."""
        return replace(
            self,
            points=mesh.positions[self.vertices].astype(float),
            normals=mesh.normals[self.vertices].astype(float),
            tangents=mesh.tangents[self.vertices].astype(float),
        )


def subdivided(mesh: Mesh, longest: float = LONGEST_EDGE, most: int = MOST_VERTICES) -> Mesh:
    """The same surface with every triangle cut into four until no edge is longer than `longest` radii or there would be
    more than `most` vertices; the mesh itself where it is fine enough."""
    limit = longest * mesh.radius
    at = mesh.positions[mesh.triangles]
    if np.linalg.norm(at - np.roll(at, 1, 1), axis=2).max(initial=0.0) <= limit:
        return mesh
    while True:
        corners, edges = mesh.triangles, mesh.edges()
        a, b = edges.T
        length = np.linalg.norm(mesh.positions[a] - mesh.positions[b], axis=1)
        if length.max(initial=0.0) <= limit or len(mesh.positions) + len(edges) > most:
            return mesh
        if 4 * len(corners) > CROWD * most:  # many triangles between few vertices
            return mesh
        count = len(mesh.positions)
        number = sparse.csr_array((np.arange(count, count + len(edges)), (a, b)), shape=(count, count))
        ends = [np.sort(corners[:, list(pair)], 1) for pair in ((0, 1), (1, 2), (2, 0))]
        m = [np.asarray(number[pair[:, 0], pair[:, 1]]).ravel() for pair in ends]
        c = corners.T
        parts = [(c[0], m[0], m[2]), (m[0], c[1], m[1]), (m[2], m[1], c[2]), (m[0], m[1], m[2])]
        # Number 4 t + n is part n of triangle t.
        triangles = np.stack([np.stack(part, 1) for part in parts], 1).reshape(-1, 3)
        middle = [0.5 * (v[a].astype(float) + v[b]) for v in (mesh.positions, mesh.normals, mesh.tangents[:, :3])]
        middle[1:] = [v / np.maximum(np.linalg.norm(v, axis=1, keepdims=True), 1e-12) for v in middle[1:]]
        tangents = np.concatenate([middle[2], mesh.tangents[a, 3:]], 1)
        mesh = Mesh(
            mesh.name,
            np.concatenate([mesh.positions, middle[0]]),
            triangles,
            np.concatenate([mesh.normals, middle[1]]),
            None if mesh.uv is None else np.concatenate([mesh.uv, 0.5 * (mesh.uv[a] + mesh.uv[b])]),
            np.concatenate([mesh.tangents, tangents]),
        )


def place_probes(
    mesh: Mesh, original: Mesh | None = None, most: int = MOST_PROBES, classes: int | None = None
) -> Probes:
    """Probes at the vertices of a mesh, or, where these are more than `most`, at a part of them so that none is farther
    than one edge from the next.

    Parameters
    ----------
    original : the mesh that was `subdivided` into this one, whose flat triangles hide light: probes are lifted off them
        to the curved surface that its normals tell of
    classes : 1, 2, 4 or 8; None: by the number of probes
    """
    count = len(mesh.positions)
    edges = mesh.edges()
    a, b = edges.T
    length = np.linalg.norm(mesh.positions[a] - mesh.positions[b], axis=1).astype(float)
    total = np.bincount(a, length, count) + np.bincount(b, length, count)
    degree = np.bincount(a, minlength=count) + np.bincount(b, minlength=count)
    offset = np.repeat((OFFSET * total / np.maximum(degree, 1))[:, None], 2, 1)
    if original is not None and original is not mesh:
        offset += lift_off_facets(mesh, original)
    graph = sparse.coo_array((np.ones(len(edges)), (a, b)), shape=(count, count)).tocsr()
    chosen, spread, graph = _thinned(_neighbours(graph + graph.T), mesh.positions.astype(float), most)
    number = len(chosen)
    if classes is None:
        classes = 1 if number <= WHOLE else 2 if number <= HALF else 4 if number <= QUARTER else 8
    if classes > 1:
        # One step reaches seven probes or so, two steps nineteen.
        two_steps = _neighbours(_two_steps(graph) + graph)
        near = graph if classes <= 4 else (0.3 * two_steps + 0.7 * graph).tocsr()
        kind = _classes(near, classes)
        near = (sparse.eye_array(number) + 0.5 * near).tocsr()
        spread = spread @ (near + _missing(near, two_steps, kind, classes))
    else:
        kind = np.zeros(number, int)
    order = np.argsort(kind, kind="stable")
    chosen, kind = chosen[order], kind[order]
    spread = _shared_evenly(spread.tocsr()[:, order].tocoo(), kind, classes)
    first = np.searchsorted(kind, np.arange(classes + 1))
    return Probes(
        mesh.positions[chosen].astype(float),
        mesh.normals[chosen].astype(float),
        mesh.tangents[chosen].astype(float),
        offset[chosen],
        first,
        spread,
        chosen,
    )


def _thinned(graph, points: np.ndarray, most: int) -> tuple:
    """At most so many nodes of a graph: their numbers, how much of them every node takes [V, P], and their own graph."""
    chosen = np.arange(len(points))
    spread = sparse.eye_array(len(points), format="csr")
    while len(chosen) > most:
        kept = _apart(graph)
        inner = _interpolation(graph, kept, points[chosen])
        spread = spread @ inner
        # Each node to the kept one that it takes most of: these heaps are neighbours where their nodes are.
        rows = np.arange(inner.shape[0])
        heap = sparse.csr_array((np.ones(len(rows)), (rows, inner.argmax(1).ravel())), inner.shape)
        graph = _neighbours(heap.T @ graph @ heap)
        chosen = chosen[kept]
    return chosen, spread, graph


def _two_steps(graph):
    """How many ways of two steps lead from node to node, but for those over hubs: all round a hub are neighbours of each
    other, which makes the square of their number."""
    degree = np.diff(graph.indptr)
    if degree.max(initial=0) <= HUB:
        return graph @ graph
    own = np.flatnonzero(degree <= HUB)
    return graph[:, own] @ graph[own]


def _neighbours(graph):
    """1 where two different nodes are connected."""
    graph = graph.tocsr()
    graph.setdiag(0.0)
    graph.eliminate_zeros()
    graph.data[:] = 1.0
    return graph


def _missing(near, farther, kind: np.ndarray, classes: int):
    """Those entries of `farther` whose class no entry of the same row of `near` is of."""
    near, farther = near.tocoo(), farther.tocoo()
    known = np.bincount(near.row * classes + kind[near.col], minlength=near.shape[0] * classes) > 0
    some = ~known[farther.row * classes + kind[farther.col]]
    return sparse.coo_array((farther.data[some], (farther.row[some], farther.col[some])), farther.shape).tocsr()


def _classes(graph, classes: int) -> np.ndarray:
    """A class [P] for each node, so that neighbours are of different ones where that can be."""
    count = graph.shape[0]
    random = np.random.default_rng(2)
    kind = random.integers(0, classes, count)
    rows = np.repeat(np.arange(count), np.diff(graph.indptr))
    for sweep in range(12):
        at = rows * classes + kind[graph.indices]
        crowd = np.bincount(at, graph.data, count * classes).reshape(count, classes).astype(float)
        crowd += 0.01 * random.random((count, classes))
        best = crowd.argmin(1)
        # Not all at once, or neighbours would change places for ever.
        change = random.random(count) < (0.5 if sweep < 8 else 0.25)
        kind = np.where(change & (crowd[np.arange(count), best] < crowd[np.arange(count), kind] - 0.05), best, kind)
    return kind


def _shared_evenly(matrix, kind: np.ndarray, classes: int):
    """The rows of a matrix so scaled that each class that a row has weighs 1."""
    group = matrix.row * classes + kind[matrix.col]
    sums = np.bincount(group, matrix.data, matrix.shape[0] * classes)
    return sparse.coo_array((matrix.data / sums[group], (matrix.row, matrix.col)), matrix.shape).tocsr()


def lift_off_facets(mesh: Mesh, original: Mesh) -> np.ndarray:
    """How far [V, 2] the curved surface lies before the flat triangles, front and back.   [Hanika 2021]"""
    levels = round(np.log2(len(mesh.triangles) / len(original.triangles)) / 2)
    corners = original.triangles[np.arange(len(mesh.triangles)) // 4**levels]
    a, b, c = (original.positions[corners[:, i]].astype(float) for i in range(3))
    lift = np.zeros((len(mesh.positions), 2))
    n = np.cross(b - a, c - a)
    n2 = np.maximum((n * n).sum(1), 1e-30)
    for i in range(3):
        vertex = mesh.triangles[:, i]
        x = mesh.positions[vertex].astype(float)
        v = np.clip((np.cross(x - a, c - a) * n).sum(1) / n2, 0.0, 1.0)
        w = np.clip((np.cross(b - a, x - a) * n).sum(1) / n2, 0.0, 1.0)
        for side, sign in ((0, 1.0), (1, -1.0)):
            height = sum(
                share * np.maximum(-sign * ((x - p) * original.normals[corners[:, j]]).sum(1), 0.0)
                for j, (share, p) in enumerate(((1.0 - v - w, a), (v, b), (w, c)))
            )
            np.maximum.at(lift[:, side], vertex, height)
    return lift


def _apart(graph) -> np.ndarray:
    """A maximal set of nodes (not the largest of all) without neighbours in it, in ascending order.

    Luby 1986: a node with the highest number among its neighbours is in, they are out; again with the rest.
    """
    count = graph.shape[0]
    rank = np.random.default_rng(1).permutation(count) + 1.0
    state = np.zeros(count, np.int8)  # 1 in, -1 out
    rows = np.repeat(np.arange(count), np.diff(graph.indptr))
    while (state == 0).any():
        here = np.where(state == 0, rank, 0.0)
        highest = np.zeros(count)
        np.maximum.at(highest, rows, here[graph.indices])
        found = (state == 0) & (here > highest)
        state[found] = 1
        state[rows[found[graph.indices] & (state[rows] == 0)]] = -1
    return np.flatnonzero(state == 1)


def _interpolation(graph, kept: np.ndarray, points: np.ndarray):
    """[V, P] sparse: how much of each kept node every node takes: itself, or the kept ones within two steps of it."""
    count = graph.shape[0]
    column = np.full(count, -1)
    column[kept] = np.arange(len(kept))
    step = graph.copy()
    step.data[:] = 1.0
    near = (step + _two_steps(step))[:, kept].tocoo()
    distance = np.linalg.norm(points[near.row] - points[kept[near.col]], axis=1)
    rows = np.repeat(np.arange(count), np.diff(graph.indptr))
    mean = np.bincount(rows, np.linalg.norm(points[rows] - points[graph.indices], axis=1), count)
    mean = mean / np.maximum(np.diff(graph.indptr), 1)
    # A kept node takes itself alone, by a weight that nothing comes near.
    weight = np.maximum(1.0 - distance / (2.5 * mean[near.row] + 1e-30), 1e-3) ** 2
    itself = column[near.row] >= 0
    weight[itself] = 0.0
    matrix = sparse.coo_array((weight, (near.row, near.col)), shape=(count, len(kept))).tocsr()
    matrix = matrix + sparse.coo_array((np.ones(len(kept)), (kept, np.arange(len(kept)))), matrix.shape).tocsr()
    matrix.eliminate_zeros()
    return sparse.diags_array(1.0 / matrix.sum(1)) @ matrix
