"""The triangles of a traced scene on the GPU: a soup that NumPy fills once (the room) and a cloth fills every frame."""

from __future__ import annotations

from typing import Any

import moderngl
import numpy as np

from ..gpu.buffers import Buffer, TextureBuffer
from ..gpu.programs import programs
from ..twins.octahedron import octahedral
from .needles import pieces_of

# A ray's hit is off by a few units in the last place of the coordinates. Boxes are padded by more than that, so that a
# triangle is also found from the cell on the other side of a plane that it touches.
PADDING = 2.0**-18


class Triangles:
    """`count` triangles as `corners` (three texels each: x, y, z, packed normal) and `attributes` (one texel each:
    material, packed x axis of each corner).

    Parameters
    ----------
    ctx : moderngl context, current
    count : how many triangles there are
    scale : the largest coordinate, in metres, that any corner or camera will have; it sets the padding of boxes
    """

    def __init__(self, ctx: moderngl.Context, count: int, scale: float):
        self.ctx = ctx
        self.count = count
        self.padding = float(scale) * PADDING
        self.corners = TextureBuffer(ctx, 48 * max(count, 1), "rgba32ui")
        self.attributes = TextureBuffer(ctx, 16 * max(count, 1), "rgba32ui")
        self.turn = np.zeros(max(count, 1), int)  # by how many places the corners of each were turned, see `set`
        self._joined = np.zeros(max(count, 1), bool)  # a triangle and its successor are a pair
        self._pairs: tuple[int, TextureBuffer] | None = None
        self.pieces: tuple[int, TextureBuffer] | None = None  # how many, and those of glcloth/accel/needles.py

    @classmethod
    def of(cls, ctx: moderngl.Context, positions: np.ndarray, material: np.ndarray | int = 0) -> Triangles:
        """The triangles of an array [T, 3, 3], flat-shaded."""
        positions = np.asarray(positions, np.float32).reshape(-1, 3, 3)
        triangles = cls(ctx, len(positions), 1.0)
        triangles.move(positions, material)
        return triangles

    def move(self, positions: np.ndarray, material: np.ndarray | int = 0) -> None:
        """All triangles anew, flat-shaded: [T, 3, 3] of as many as there are."""
        positions = np.asarray(positions, np.float32)
        self.padding = (float(np.abs(positions).max(initial=0.0)) or 1.0) * PADDING
        self.set(0, positions, material=material)
        self._take_pieces(pieces_of(rotated_corners(without_lines(positions), self.turn[: len(positions)])))

    def cut_needles(self, wanted: bool) -> None:
        """Long thin triangles, which a pass has written, enter a hierarchy in pieces from now on; not `wanted`: whole."""
        self._take_pieces(pieces_of(self.positions()) if wanted else None)

    def _take_pieces(self, found: np.ndarray | None) -> None:
        if self.pieces is not None:
            self.pieces[1].release()
        self.pieces = None if found is None else (len(found), TextureBuffer(self.ctx, found, "rgba32ui"))

    def set(
        self,
        first: int,
        positions: np.ndarray,
        normals: np.ndarray | None = None,
        tangents: np.ndarray | None = None,
        material: np.ndarray | int = 0,
    ) -> None:
        """Upload triangles from number `first` on.

        Parameters
        ----------
        positions : [T, 3, 3] metres
        normals, tangents : [T, 3, 3] of the corners; default: the geometric normal, and the first edge
        material : [T] int or one for all

        Successive triangles that share an edge become pairs; their corners are turned for it, the order of the round kept.
        So hits are between the turned corners, `rotated_corners(corners, triangles.turn)`.
        """
        positions = without_lines(np.asarray(positions, np.float32).reshape(-1, 3, 3))
        T = len(positions)
        assert first + T <= self.count, f"{first} + {T} triangles, room for {self.count}"
        material = np.broadcast_to(material, T)
        turn, joined = self.turn[first : first + T], self._joined[first : first + T]
        # Cloth that moves keeps its pairs.
        if not joined.any() or not _are_pairs(rotated_corners(positions, turn), material, joined):
            turn, joined = find_pairs(positions, material)
            self.turn[first : first + T] = turn
        self._join(first, joined)
        positions = np.ascontiguousarray(rotated_corners(positions, turn))
        normals, tangents = (None if v is None else rotated_corners(np.asarray(v), turn) for v in (normals, tangents))
        edges = (positions[:, 1] - positions[:, 0]).astype(float), (positions[:, 2] - positions[:, 0]).astype(float)
        if normals is None:
            normals = np.cross(*edges)[:, None]
        if tangents is None:
            tangents = edges[0][:, None]
        corners = np.empty((T, 3, 4), np.uint32)
        corners[..., :3] = positions.view(np.uint32)
        corners[..., 3] = pack_units(normals)
        attributes = np.empty((T, 4), np.uint32)
        attributes[:, 0] = material
        attributes[:, 1:] = pack_units(tangents)
        self.corners.write(corners, offset=48 * first)
        self.attributes.write(attributes, offset=16 * first)

    def set_grid(
        self,
        first: int,
        rows: int,
        columns: int,
        positions: Buffer,
        normals: Buffer,
        tangents: Buffer,
        material: int = 0,
    ) -> None:
        """Copy the 2 (rows - 1) (columns - 1) triangles of a grid whose buffers hold one vec4 a vertex, row by row."""
        quads = (rows - 1) * (columns - 1)
        self._join(first, np.tile([True, False], quads))
        assert first + 2 * quads <= self.count, f"{first} + {2 * quads} triangles, room for {self.count}"
        programs(self.ctx).compute("passes/accel/gather_grid.comp").run(
            quads, Positions=positions, Normals=normals, Tangents=tangents, Corners=self.corners,
            Attributes=self.attributes, rows=rows, columns=columns, first=first, material=material,
        )  # fmt: skip

    def take(self, corners: np.ndarray, attributes: np.ndarray) -> None:
        """All triangles as others have them on the GPU: uint32 [T, 12] and [T, 4]; two successive ones are a pair."""
        self._join(0, np.arange(self.count) % 2 == 0)
        self.corners.write(np.ascontiguousarray(corners))
        self.attributes.write(np.ascontiguousarray(attributes))

    def pairs(self) -> tuple[int, TextureBuffer]:
        """How many pairs and single triangles there are, and a texel for each: twice the first triangle's number, plus 1 if
        its successor belongs to it.

        A pair is (a, c, b) and (b, c, d).
        """
        if self._pairs is None:
            joined = self._joined[: self.count]
            begins = np.ones(self.count, bool)
            begins[1:] = ~joined[:-1]
            first = np.flatnonzero(begins).astype(np.uint32)
            self._pairs = len(first), TextureBuffer(self.ctx, 2 * first + joined[first].astype(np.uint32), "r32ui")
        return self._pairs

    def inputs(self) -> dict[str, Any]:
        """The corners and the attributes, as most passes call them."""
        return {"corners": self.corners, "attributes": self.attributes}

    def _join(self, first: int, joined: np.ndarray) -> None:
        there = self._joined[first : first + len(joined)]
        if not np.array_equal(there, joined):
            there[:] = joined
            self._forget_pairs()

    def _forget_pairs(self) -> None:
        if self._pairs is not None:
            self._pairs[1].release()
        self._pairs = None

    def positions(self) -> np.ndarray:
        """Read the corners back: float32 [T, 3, 3]."""
        data = np.frombuffer(self.corners.read(48 * self.count), np.uint32).reshape(-1, 3, 4)
        return np.ascontiguousarray(data[..., :3]).view(np.float32)

    def materials(self) -> np.ndarray:
        """Read the materials back: int [T]."""
        data = np.frombuffer(self.attributes.read(16 * self.count), np.uint32).reshape(-1, 4)
        return data[:, 0].astype(int)

    def release(self) -> None:
        """Free the GPU's memory."""
        self._forget_pairs()
        if self.pieces is not None:
            self.pieces[1].release()
        self.corners.release()
        self.attributes.release()


def without_lines(positions: np.ndarray) -> np.ndarray:
    """Triangles [T, 3, 3] float32, those without area drawn together to a point: that no ray meets, to the last bit, while
    rounding lets some meet a line. A height below 2e-6 of the longest side is rounding."""
    p = positions.astype(np.float64)
    edges = np.roll(p, -1, 1) - p
    longest = np.einsum("tkc,tkc->tk", edges, edges).max(1, initial=0.0)
    thin = np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1) <= 2e-6 * longest
    if not thin.any():
        return positions
    return np.where(thin[:, None, None], positions[:, :1], positions)


def find_pairs(positions: np.ndarray, material: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Which triangles [T, 3, 3] form a pair (a, c, b), (b, c, d) with their successor, [T] bool, and by how many places the
    corners of each must be turned for it, [T] int. Only neighbours in the list, of one material, no triangle in two pairs.
    """
    T = len(positions)
    turn, joined = np.zeros(T, int), np.zeros(T, bool)
    if T < 2:
        return turn, joined
    fits = np.full(T - 1, -1)
    for k in range(3):
        for l in range(3):
            c, b = positions[:-1, (k + 1) % 3], positions[:-1, (k + 2) % 3]
            shared = (positions[1:, l] == b).all(1) & (positions[1:, (l + 1) % 3] == c).all(1)
            fits[shared & (fits < 0)] = 3 * k + l
    fits[material[1:] != material[:-1]] = -1
    # Of several in a row that fit their successors every second one, from the first on, is joined.
    place, fit = np.arange(T - 1), fits >= 0
    first = np.maximum.accumulate(np.where(fit & ~np.concatenate([[False], fit[:-1]]), place, 0))
    joined[:-1] = fit & ((place - first) % 2 == 0)
    t = np.flatnonzero(joined)
    turn[t], turn[t + 1] = np.divmod(fits[t], 3)
    return turn, joined


def _are_pairs(corners: np.ndarray, material: np.ndarray, joined: np.ndarray) -> bool:
    """Whether triangles [T, 3, 3], turned, that are `joined` [T] to their successors share edges with these."""
    t = np.flatnonzero(joined)
    alike = np.array_equal(corners[t, 1], corners[t + 1, 1]) and np.array_equal(corners[t, 2], corners[t + 1, 0])
    return alike and np.array_equal(material[t], material[t + 1])


def rotated_corners(corners: np.ndarray, turn: np.ndarray) -> np.ndarray:
    """Corners [T, 3, ...] that begin with the one that was number `turn` [T]."""
    return corners[np.arange(len(corners))[:, None], (turn[:, None] + np.arange(3)) % 3]


def pack_units(vectors: np.ndarray) -> np.ndarray:
    """Directions [..., 3] as uint32 [...]: the octahedral map in two signed 16-bit fractions. A zero vector becomes +z."""
    vectors = np.asarray(vectors, float)
    vectors = np.where(np.abs(vectors).sum(-1, keepdims=True) > 0, vectors, [0.0, 0.0, 1.0])
    fraction = np.round(octahedral(vectors) * 32767).astype(np.int64) & 0xFFFF
    return (fraction[..., 0] | fraction[..., 1] << 16).astype(np.uint32)
