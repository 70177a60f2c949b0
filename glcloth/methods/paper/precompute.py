"""T of equation 9, computed on the CPU and compressed by SVD: what the paper method's tables hold of a fabric (paper A)."""

from __future__ import annotations

import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
from threadpoolctl import threadpool_limits

from ...fabric import Fabric
from ...gpu.layout import shared
from ...progress import track
from ...twins import coordinates
from ...twins.convolution import theta_end
from .shapes import Placement, Shape, shapes_of

_CONSTANTS = shared("sg/coordinates.glsl")[0]
LEVELS = int(_CONSTANTS["LEVELS"])
ALL_ROWS = slice(None)
CELLS = (
    96  # quadrature cells over theta and phi of the tangent's hemisphere: 1.9 degrees, the sharpest lobe is 2.1 wide
)
BATCH = 24  # rows of W at a time, so that what is computed stays in the cache
NEGLIGIBLE = 22.0  # exp(-22) = 3e-10


def sharpness_levels() -> np.ndarray:
    """Sharpness [LEVELS] of the levels of T: 0, then 0.5 to 1500 in equal ratios."""
    return coordinates.sharpness_from_level(
        np.arange(LEVELS), _CONSTANTS["SHARPNESS_FIRST"], _CONSTANTS["SHARPNESS_LAST"], LEVELS
    )


def inner_share(grid: int) -> float:
    """The share of the phi axis of xi, from phi = 0 on, that lies inside the tangent's hemisphere: three quarters."""
    inside = grid - 2 * round(grid / 8)
    return (inside - 1) / (grid - 1)


def weight_axes(grid: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The nodes (theta of both directions, phi of xi over the whole circle, phi of omega_o) [grid] each."""
    x = np.linspace(0, 1, grid)
    theta = coordinates.half_circle_from_unit(x)
    u = 2 * x - 1
    return theta, np.copysign(coordinates.circle_from_unit(np.abs(u), inner_share(grid)), u), theta.copy()


def _directions(theta: np.ndarray, phi: np.ndarray) -> np.ndarray:
    """Unit vectors [theta * phi, 3] = (omega . t, omega . b, omega . n)."""
    theta, phi = (a.ravel() for a in np.meshgrid(theta, phi, indexing="ij"))
    return np.stack([np.sin(theta), np.cos(theta) * np.sin(phi), np.cos(theta) * np.cos(phi)], -1)


def _cells() -> np.ndarray:
    return coordinates.half_circle_from_unit((np.arange(CELLS) + 0.5) / CELLS)


def W_matrix(shape: Shape, omega_i: np.ndarray, omega_o: np.ndarray) -> np.ndarray:
    """W [I, O] float32 for directions in the tangent's frame, without the clamp at the horizon of N.   [Miz 6]"""
    c, s = np.cos(shape.tilt), np.sin(shape.tilt)
    surface_from_tangent = np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])
    i, o = omega_i @ surface_from_tangent.T, omega_o @ surface_from_tangent.T

    def single(x):
        return np.ascontiguousarray(x, np.float32)

    def cosines(angle):
        return single(np.maximum(np.cos(angle), 0.0))

    phi_i, phi_o = np.arctan2(omega_i[:, 1], omega_i[:, 2]), np.arctan2(omega_o[:, 1], omega_o[:, 2])
    yarns = []
    for axis, tangents in ((0, shape.own), (1, shape.other)):
        psi_i, psi_o = np.arctan2(i[:, axis], i[:, 2]), np.arctan2(o[:, axis], o[:, 2])
        lengths = [(cosines(psi_i - tilt), cosines(psi_o - tilt), np.float32(share)) for tilt, share in tangents]
        yarns.append((single(psi_i / shape.sigma), single(psi_o / shape.sigma), lengths))
    at = [tilt for tilt, _ in shape.own].index(shape.tilt)
    gap = single(shape.gap * np.maximum(o[:, 2], 0.0))
    mask_i, mask_o, turn_i, turn_o = (
        cosines(phi_i),
        cosines(phi_o),
        single(phi_i / shape.sigma),
        single(phi_o / shape.sigma),
    )
    turn = np.float32(2 * np.pi / shape.sigma)
    W = np.empty((len(omega_i), len(omega_o)), np.float32)

    def rows(first):
        part = slice(first, min(first + BATCH, len(omega_i)))
        normaliser = np.broadcast_to(gap, (part.stop - part.start, len(gap))).copy()
        own = None
        for axis, (psi_i, psi_o, lengths) in enumerate(yarns):
            d = np.abs(psi_i[part, None] - psi_o)
            np.minimum(d, turn - d, out=d)
            g = np.exp(-d * d)
            both, less = np.zeros_like(d), np.zeros_like(d)
            for k, (y, z, share) in enumerate(lengths):
                product, smaller = y[part, None] * z, np.minimum(y[part, None], z)
                if axis == 0 and k == at:
                    own = product + g * (smaller - product)
                both += share * product
                less += share * smaller
            normaliser += both + g * (less - both)
        d = turn_i[part, None] - turn_o
        product, smaller = mask_i[part, None] * mask_o, np.minimum(mask_i[part, None], mask_o)
        numerator = (product + np.exp(-d * d) * (smaller - product)) * own
        out = W[part]
        out[...] = 0.0
        np.divide(numerator, normaliser, out=out, where=normaliser > 0)

    with ThreadPoolExecutor(2) as pool:  # NumPy lets go of the interpreter lock
        list(pool.map(rows, range(0, len(omega_i), BATCH)))
    return W


def _W_of_cells(shape: Shape, theta_o: np.ndarray, phi_o: np.ndarray) -> np.ndarray:
    """W [CELLS * CELLS, theta_o * phi_o] with omega_i at the cells; computed once for both halves of symmetric fabrics."""
    q, omega_o = _cells(), _directions(theta_o, phi_o)
    if shape.mirrored(1, -1) != shape:
        return W_matrix(shape, _directions(q, q), omega_o)
    half = W_matrix(shape, _directions(q, q[: CELLS // 2]), omega_o)
    half = half.reshape(CELLS, CELLS // 2, len(theta_o), len(phi_o))
    return np.concatenate([half, half[:, ::-1, :, ::-1]], axis=1).reshape(CELLS * CELLS, -1)


def horizon_share(tilt: float, theta: np.ndarray, phi: np.ndarray) -> np.ndarray:
    """The part of each cell of the (theta, phi) grid that lies above the horizon of N, [theta * phi].

    z = -sin(theta) sin(tilt) + cos(theta) cos(phi) cos(tilt) > 0 is |phi| < acos(tan(tilt) tan(theta)).
    """
    half = (phi[1] - phi[0]) / 2
    with np.errstate(invalid="ignore"):
        limit = np.arccos(np.clip(np.sin(tilt) * np.sin(theta) / (np.cos(tilt) * np.cos(theta) + 1e-300), -1, 1))
    return np.clip((limit[:, None] - np.abs(phi) + half) / (2 * half), 0, 1).ravel()


def end_share(tilt: float, theta: np.ndarray) -> np.ndarray:
    """The part of each row of the (theta, phi) grid that lies in the domain of T and I, [theta]."""
    half = (theta[1] - theta[0]) / 2
    along = np.copysign(theta, theta * tilt) if tilt else theta
    return np.clip((theta_end(tilt) - along + half) / (2 * half), 0, 1)


def _factor(A: np.ndarray, rank: int) -> tuple[np.ndarray, np.ndarray]:
    """A ~ left @ right.T with orthonormal columns of right, by a randomised range finder (Halko et al. 2011, 4.4).

    A quarter of the rows spans the same space: W changes little from cell to cell. The seed is fixed, so that tables
    come out the same every time.
    """
    if rank >= A.shape[1]:
        return A, np.eye(A.shape[1], dtype=np.float32)
    sample = np.ascontiguousarray(A.reshape(CELLS, CELLS, -1)[::2, 1::2].reshape(CELLS * CELLS // 4, -1))
    probe = np.random.default_rng(0).standard_normal((len(sample), rank), np.float32)
    basis = np.linalg.qr(sample.T @ probe)[0]
    basis = np.linalg.qr(sample.T @ (sample @ basis))[0]
    return A @ basis, basis


def working_rank(contribution: float, columns: int) -> int:
    """How many singular values are computed, so that those beyond matter little to the share that is asked for."""
    return min(columns, int(np.interp(np.log10(1 - contribution), [-4, -3, -2, -1], [1280, 704, 320, 192])))


def _nodes(sharpness: float, columns: np.ndarray, rows: slice = ALL_ROWS) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(nodes in theta, in phi, columns [nodes, nodes, C]) on which sums with the Gaussian equal those over the cells to
    about 1e-6. Only these `rows` of cells in theta hold anything.

    A broad Gaussian is a polynomial of low degree over the hemisphere: it is evaluated at Chebyshev nodes only, and the
    cells' values are gathered there once by the transpose of the interpolation from the nodes to the cells.
    """
    q = _cells()
    count = 16 + int(8 * np.sqrt(sharpness))
    if count >= CELLS:
        return q[rows], q, columns[rows]
    nodes = np.cos(np.pi * (np.arange(count) + 0.5) / count)[::-1]
    degree = np.arange(count)
    at_nodes = np.cos(degree * np.arccos(nodes)[:, None])
    at_nodes[:, 0] *= 0.5

    def cells_from_nodes(middle, half, cells):
        at_cells = np.cos(degree * np.arccos((cells - middle) / half)[:, None])
        return (at_cells @ at_nodes.T * (2 / count)).astype(np.float32)

    # The whole axis, or that from the first cell's far side to the last one's.
    margin = 0.5 * (q[1] - q[0])
    low, high = q[rows][0] - margin, q[rows][-1] + margin
    middle, half = (0.0, np.pi / 2) if rows == ALL_ROWS else (0.5 * (low + high), 0.5 * (high - low))
    gathered = np.tensordot(cells_from_nodes(middle, half, q[rows]), columns[rows], (0, 0))
    gathered = np.tensordot(gathered, cells_from_nodes(0.0, np.pi / 2, q), (1, 0)).transpose(0, 2, 1)
    return middle + nodes * half, nodes * np.pi / 2, np.ascontiguousarray(gathered)


def _convolved(
    sharpness: float, theta_k: np.ndarray, phi_k: np.ndarray, columns: np.ndarray, rows: slice = ALL_ROWS
) -> np.ndarray:
    """Integrals of G_k times `columns` [CELLS, CELLS, C] over that of G_k alone, [theta_k * phi_k, C - 1].   [Miz 9]

    The last column holds the solid angles of the cells, the others are multiplied by them. The Gaussian is scaled to 1
    at its nearest node, because sharp lobes far outside the hemisphere vanish otherwise; rows of nodes where it is
    negligible are left out. `rows` as in `_nodes`.
    """
    q, phi, columns = _nodes(sharpness, columns, rows)
    across = np.cos(phi_k[:, None] - phi).astype(np.float32)
    best = across.max(1)
    out = np.empty((len(theta_k), len(phi_k), columns.shape[2] - 1), np.float32)
    inside = np.abs(phi_k) <= np.pi / 2 + 1e-9

    def row(a):
        along, level = np.sin(theta_k[a]) * np.sin(q), np.cos(theta_k[a]) * np.cos(q)
        nearest = along + level * best[:, None]
        top = nearest.max(1)
        for part in (inside, ~inside):
            used = np.any(sharpness * (nearest[part] - top[part, None]) > -NEGLIGIBLE, axis=0)
            rows = slice(np.argmax(used), len(q) - np.argmax(used[::-1]))
            scale = (sharpness * level[rows]).astype(np.float32)
            offset = (sharpness * (along[rows] - top[part, None])).astype(np.float32)
            G = across[part, None, :] * scale[:, None]
            G += offset[..., None]
            np.maximum(G, -40.0, out=G)  # smaller ones are denormal, which is slow
            np.exp(G, out=G)
            sums = G.reshape(len(G), -1) @ columns[rows].reshape(-1, columns.shape[2])
            out[a, part] = sums[:, :-1] / sums[:, -1:]

    with ThreadPoolExecutor(2) as pool:
        list(pool.map(row, range(len(theta_k))))
    return out.reshape(len(theta_k) * len(phi_k), -1)


def _compressed(C: np.ndarray, basis: np.ndarray, contribution: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(xi [rank, X], o [rank, O], singular values) of the smallest SVD of C @ basis.T that reaches the contribution.

    The singular values of T come from its Gram matrix in double precision, which costs far less than a dense SVD and
    is as good down to 1e-8 of the largest.
    """
    C = C.astype(np.float64)
    square, V = np.linalg.eigh(C.T @ C)
    values, V = np.sqrt(np.maximum(square[::-1], 0.0)), V[:, ::-1]
    rank = rank_for(values, contribution)
    values, V = values, V[:, :rank]
    # The sign of a singular pair is free; fixed, so that tables compare.
    V = V * np.where((basis @ V).sum(0) < 0, -1.0, 1.0)
    root = np.sqrt(np.maximum(values[:rank], 1e-300))
    return (C @ V / root).T.astype(np.float32), (basis @ (V * root)).T.astype(np.float32), values


def rank_for(values: np.ndarray, contribution: float) -> int:
    """The smallest number of singular values whose sum reaches the contribution of the sum of all.   [Miz section 4]

    `values` may be the first ones of a longer spectrum.
    """
    total = _sum_of_all(values)
    return min(int(np.searchsorted(np.cumsum(values), contribution * total * (1 - 1e-12))) + 1, len(values))


def _sum_of_all(values: np.ndarray) -> float:
    """The sum of a whole spectrum whose first values these are.

    The last quarter of them is too small, because the low-rank W misses part of it: from there on the spectrum is taken
    to fall as a power of the index. Measured against dense SVDs: within 0.2 % at the sharpest level.
    """
    count = 3 * len(values) // 4
    if count < 8 or values[count - 1] <= 1e-7 * values[0]:
        return float(values.sum())
    last = values[count - 1]
    power = max(np.log(values[count // 2] / last) / np.log((count - 1) / (count // 2)), 1.5)
    return float(values[:count].sum() + last * count / (power - 1))


@dataclass(frozen=True)
class Tables:
    """T of every tangent of a fabric, SVD-compressed per sharpness level.   [Miz 9, section 3]

    Parameters
    ----------
    grid : nodes of each of theta and phi
    contribution : the share of the sum of singular values that is kept
    placements : for each tangent the shape whose table it reads
    xi, o : [shape][level] arrays [rank, grid (theta), grid (phi)] float32; T = sum over rank of xi * o
    values : [shape][level] singular values that were computed
    seconds : what it took to make them, 0 when they were read from the cache
    """

    grid: int
    contribution: float
    placements: tuple[Placement, ...]
    xi: tuple[tuple[np.ndarray, ...], ...]
    o: tuple[tuple[np.ndarray, ...], ...]
    values: tuple[tuple[np.ndarray, ...], ...]
    seconds: float = 0.0

    @property
    def ranks(self) -> np.ndarray:
        """[shapes, LEVELS] numbers of singular values kept."""
        return np.array([[len(level) for level in shape] for shape in self.xi])


def _same_domain(
    shapes: tuple[Shape, ...], left: list[np.ndarray], solid_angle: np.ndarray
) -> Iterator[tuple[list[int], np.ndarray, slice]]:
    """(shapes whose domain is the whole hemisphere, or one that is upright; their columns for `_convolved`; its rows)."""
    q = _cells()
    whole = [n for n, shape in enumerate(shapes) if theta_end(shape.tilt) >= np.pi / 2]
    for numbers in (whole, *([n] for n in range(len(shapes)) if n not in whole)):
        if not numbers:
            continue
        share = end_share(shapes[numbers[0]].tilt, q)
        inside = np.flatnonzero(share)
        rows = ALL_ROWS if numbers is whole else slice(inside[0], inside[-1] + 1)
        domain = solid_angle * np.repeat(share, CELLS).astype(np.float32)[:, None]
        yield numbers, np.concatenate([*(left[n] for n in numbers), domain], axis=1).reshape(CELLS, CELLS, -1), rows


# The rows of a product run on threads of ours; threads of the BLAS below them would only fight with those.
@threadpool_limits.wrap(limits=1, user_api="blas")
def compute_tables(fabric: Fabric, grid: int = 48, contribution: float = 0.9) -> Tables:
    """Compute T of a fabric on grid x grid directions for xi (whole sphere) and for omega_o (the tangent's hemisphere).

    T_sigma = K_sigma W with W low-rank: W ~ left right^T once, then K_sigma left per level and a small SVD each.
    """
    began = time.perf_counter()
    shapes, placements = shapes_of(fabric)
    theta, phi_k, phi_o = weight_axes(grid)
    q = _cells()
    # At the ends of theta_o W depends on the way there; the nodes take the limit along their phi_o.
    limit = np.clip(theta, -np.pi / 2 + 1e-4, np.pi / 2 - 1e-4)
    rank = working_rank(contribution, grid * grid)
    solid_angle = np.repeat(np.cos(q), CELLS)[:, None].astype(np.float32)
    left, basis = [], []
    for shape in track(shapes, "tables: weights W"):
        W = _W_of_cells(shape, limit, phi_o)
        W *= solid_angle * horizon_share(shape.tilt, q, q).astype(np.float32)[:, None]
        A, B = _factor(W, rank)
        left.append(A)
        basis.append(B)
    groups = list(_same_domain(shapes, left, solid_angle))
    parts: list[list[tuple]] = [[] for _ in shapes]
    for sharpness in track(sharpness_levels(), "tables: convolution with the Gaussians, SVD"):
        for numbers, columns, rows in groups:
            C = _convolved(float(sharpness), theta, phi_k, columns, rows)
            ends = np.cumsum([left[n].shape[1] for n in numbers])[:-1]
            for n, own in zip(numbers, np.split(C, ends, axis=1), strict=True):
                parts[n].append(_compressed(own, basis[n], contribution))
    xi, o, values = (tuple(tuple(level[k] for level in shape) for shape in parts) for k in range(3))
    xi, o = (tuple(tuple(a.reshape(-1, grid, grid) for a in shape) for shape in side) for side in (xi, o))
    return Tables(grid, contribution, placements, xi, o, values, time.perf_counter() - began)
