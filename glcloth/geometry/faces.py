"""The triangles of a mesh as vectors, component by component: arrays [3, T] are passed through three times as fast as
[T, 3]."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

CHUNK = 1 << 13


@dataclass(frozen=True, eq=False)
class Faces:
    """Triangles and what follows from their corners.

    Parameters
    ----------
    triangles : [T, 3]
    edges : [3, 3, T] from corner k to the next one, x y z
    area : [3, T] the normal scaled by the area, exactly 0 for triangles that are lines or points
    """

    triangles: np.ndarray
    edges: np.ndarray
    area: np.ndarray

    @classmethod
    def of(cls, positions: np.ndarray, triangles: np.ndarray) -> Faces:
        """The faces of positions [V, 3], which are exact in float32."""
        edges, area = np.empty((3, 3, len(triangles))), np.empty((3, len(triangles)))
        for part in chunks(len(triangles)):
            at = gathered(positions, triangles[part])
            e, S = edges[..., part], area[:, part]
            for k in range(3):
                e[k] = at[(k + 1) % 3] - at[k]
            S[:] = cross(e[0], -e[2]) / 2
            longest = np.maximum(np.maximum(dot(e[0], e[0]), dot(e[1], e[1])), dot(e[2], e[2]))
            # Positions are float32, so heights below 1e-6 of the longest side are rounding, not shape.
            S[:, np.sqrt(dot(S, S)) <= 1e-6 * longest] = 0.0
        return cls(triangles, edges, area)

    def some(self, which: np.ndarray) -> Faces:
        """The faces of these numbers."""
        return Faces(self.triangles[which], self.edges[..., which], self.area[:, which])

    def turned(self, over: np.ndarray) -> Faces:
        """The same with those turned over where `over` [T]."""
        back = -self.edges[[1, 0, 2]]  # corners c b a: from c to b, b to a, a to c
        return Faces(
            np.where(over[:, None], self.triangles[:, ::-1], self.triangles),
            np.where(over, back, self.edges),
            np.where(over, -self.area, self.area),
        )

    def renumbered(self, triangles: np.ndarray) -> Faces:
        """The same between vertices of other numbers."""
        return replace(self, triangles=triangles)

    def angles(self) -> np.ndarray:
        """The interior angles [3, T] in radians."""
        angles = np.empty((3, len(self.triangles)))
        for part in chunks(len(self.triangles)):
            e = unit(self.edges[..., part])
            for k in range(3):
                angles[k, part] = np.arccos(np.clip(-dot(e[k], e[k - 1]), -1.0, 1.0))
        return angles


def chunks(count: int) -> Iterator[slice]:
    """Parts of so many triangles that stay in the processor's cache: twice as fast as all at once."""
    return (slice(begin, min(begin + CHUNK, count)) for begin in range(0, count, CHUNK))


def gathered(values: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """The values [V, n] of corners: [3, n, T]."""
    out = np.empty((3, values.shape[1], len(triangles)))
    for k in range(3):
        for n, column in enumerate(values.T):
            out[k, n] = column[triangles[:, k]]
    return out


def sums(group: np.ndarray, triangles: np.ndarray, value: np.ndarray) -> np.ndarray:
    """Sum the values [3, n, T] of corners at each vertex, vertices of one `group` [V] counting as one; [V, n]."""
    corner = group[triangles.ravel()]
    columns = [np.bincount(corner, value[:, k].T.ravel(), group.max() + 1) for k in range(value.shape[1])]
    return np.stack(columns, 1)[group]


def dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """The dot products [...] of vectors [..., 3, T]."""
    return a[..., 0, :] * b[..., 0, :] + a[..., 1, :] * b[..., 1, :] + a[..., 2, :] * b[..., 2, :]


def cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """The cross products [3, T] of vectors [3, T]."""
    return np.stack([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


def unit(a: np.ndarray) -> np.ndarray:
    """a / |a| of vectors [..., 3, T]; zero stays zero."""
    length = np.sqrt(dot(a, a))
    return a / np.where(length == 0, 1.0, length)[..., None, :]
