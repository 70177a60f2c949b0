"""The acceleration structure as a picture: primitives with black edges, boxes of nodes in green.   [Mat section 4.3.3]

The lamp is light yellow, the axes grey, the primitives have their diffuse colour; nothing is shaded, everything is
z-buffered.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, NamedTuple

import moderngl
import numpy as np

from ..errors import InputError
from ..geometry.camera import Camera
from ..gpu.buffers import TextureBuffer
from ..gpu.programs import programs
from .canvas import Canvas

YELLOW, GREEN, GREY, BLACK, PAPER, BLUE = (
    (1.0, 0.95, 0.45),
    (0.05, 0.65, 0.1),
    (0.5, 0.5, 0.5),
    (0.0, 0.0, 0.0),
    (1.0, 1.0, 1.0),
    (0.05, 0.15, 0.75),
)
EDGES = [(0, 1), (0, 2), (0, 4), (1, 3), (1, 5), (2, 3), (2, 6), (3, 7), (4, 5), (4, 6), (5, 7), (6, 7)]
OVERSAMPLING = 2
PIECE = 24_000  # vertices drawn at a time: whole triangles and whole lines


def box_lines(low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """The twelve edges [N, 12, 2, 3] of boxes with corners low, high [N, 3]."""
    corner = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)])
    points = low[:, None] + corner * (high - low)[:, None]
    return points[:, np.array(EDGES)]


def shown_nodes(tree: dict[str, np.ndarray], level: int | None) -> np.ndarray:
    """The numbers of the nodes to draw: of one level, or (level None) the leaves that hold triangles.

    Raises InputError for a structure without boxes and for a level that the tree does not have.
    """
    if "low" not in tree:
        raise InputError("brute force has no tree to show; choose kdtree or lbvh")
    if level is None:
        return np.flatnonzero((tree["axis"] == 3) & (tree["count"] > 0))
    deepest = int(tree["depth"].max())
    if not 0 <= level <= deepest:
        raise InputError(f"tree level {level}: this tree has levels 0 to {deepest}; choose one of them, or leaves")
    return np.flatnonzero(tree["depth"] == level)


@dataclass(frozen=True)
class TreeContent:
    """The content of a picture of a structure, and its view.

    tree : `arrays()` of a structure that has boxes (kdtree or lbvh). positions : [T, 3, 3]; colors : [T, 3] diffuse, linear.
    lamp : position of the lamp. hidden : [T] bool, triangles to leave out (walls that would hide the rest).
    points : [N, 3], what a tree of points holds.
    """

    tree: dict[str, np.ndarray]
    positions: np.ndarray
    colors: np.ndarray
    camera: Camera
    lamp: tuple[float, float, float] | None = None
    hidden: np.ndarray | None = None
    points: np.ndarray | None = None


class TreePicture:
    """Draws structures into a texture of its own, again and again: `texture`, RGBA, linear, bottom row first."""

    def __init__(self, ctx: moderngl.Context):
        self.ctx = ctx
        self.boxes = 0
        self._vertices = TextureBuffer(ctx, 64)
        self._canvas: Canvas | None = None

    @property
    def texture(self) -> moderngl.Texture | None:
        """The picture; None before the first."""
        return None if self._canvas is None else self._canvas.texture

    def draw(self, content: TreeContent, size: tuple[int, int], level: int | None = None) -> int:
        """Draw as `steps` does, all at once; returns how many boxes it drew."""
        for _ in self.steps(content, size, level):
            pass
        return self.boxes

    def steps(self, content: TreeContent, size: tuple[int, int], level: int | None = None) -> Iterator[None]:
        """Draw a structure and the triangles that it holds, a part at a time, for a caller with other things to do.

        level : draw the boxes of this level; None: of the leaves that hold triangles

        `boxes` says afterwards how many were drawn. Raises InputError for a structure without boxes or a level that it
        does not have.
        """
        nodes = shown_nodes(content.tree, level)
        parts = _parts(content, nodes)
        every = np.concatenate([content.positions.reshape(-1, 3), *(part.points for part in parts)])
        clip_from_world = content.camera.clip_from_world(size, *content.camera.depth_range(every.min(0), every.max(0)))
        canvas = self._sized(size)
        canvas.clear(PAPER)
        self.boxes = len(nodes)
        program = programs(self.ctx).draw("passes/tracing/plain.vert", "passes/tracing/plain.frag")
        for points, tint, mode, nearer in parts:
            for first in range(0, len(points), PIECE):
                count = len(points[first : first + PIECE])
                data = np.zeros((count, 2, 4), np.float32)
                data[:, 0, :3] = points[first : first + PIECE]
                data[:, 1, :3] = np.broadcast_to(tint, points.shape)[first : first + PIECE]
                self._vertices.write(data)
                program.bind(vertices=self._vertices, clip_from_world=clip_from_world, nearer=nearer)
                canvas.draw(program, mode, count)
                yield

    def _sized(self, size: tuple[int, int]) -> Canvas:
        if self._canvas is None or self._canvas.texture.size != tuple(size):
            if self._canvas is not None:
                self._canvas.release()
            self._canvas = Canvas(self.ctx, size)
        return self._canvas

    def pixels(self) -> np.ndarray:
        """Return the picture as float32 [H, W, 3], top row first."""
        assert self._canvas is not None, "call draw first"
        return self._canvas.pixels()

    def release(self) -> None:
        """Free the GPU's memory."""
        if self._canvas is not None:
            self._canvas.release()
        self._vertices.release()


def draw_tree(
    ctx: moderngl.Context, content: TreeContent, size: tuple[int, int], level: int | None = None
) -> np.ndarray:
    """Draw a structure and the triangles that it holds, once; parameters and errors as for TreePicture.steps.

    Returns float32 [H, W, 3], linear, top row first.
    """
    k = OVERSAMPLING
    picture = TreePicture(ctx)
    try:
        picture.draw(content, (size[0] * k, size[1] * k), level)
        return picture.pixels().reshape(size[1], k, size[0], k, 3).mean((1, 3)).astype(np.float32)
    finally:
        picture.release()


class Part(NamedTuple):
    """Vertices [N, 3], their colour [3] or colours [N, 3], their primitive, and how much nearer they are drawn."""

    points: np.ndarray
    tint: Any
    mode: int
    nearer: float


def _parts(content: TreeContent, nodes: np.ndarray) -> list[Part]:
    """The parts of the picture: primitives, their edges, the lamp, the boxes of some nodes, the axes."""
    tree, positions = content.tree, content.positions
    bound_low, bound_high = positions.min((0, 1)).astype(float), positions.max((0, 1)).astype(float)
    low, high = (tree[name][nodes].astype(float) for name in ("low", "high"))
    boxes = box_lines(np.maximum(low, bound_low), np.minimum(high, bound_high)).reshape(-1, 3)
    length = float(np.linalg.norm(bound_high - bound_low))
    axes = np.array([[[0, 0, 0], axis] for axis in 0.5 * length * np.eye(3)]).reshape(-1, 3)
    bulb = np.zeros((0, 3)) if content.lamp is None else _octahedron(np.array(content.lamp, float), 0.02 * length)
    keep = np.ones(len(positions), bool) if content.hidden is None else ~np.asarray(content.hidden)
    triangles = positions[keep]
    edges = triangles[:, [0, 1, 1, 2, 2, 0]]
    return [
        Part(triangles.reshape(-1, 3), np.repeat(np.asarray(content.colors)[keep], 3, 0), moderngl.TRIANGLES, 0.0),
        Part(edges.reshape(-1, 3), BLACK, moderngl.LINES, 2e-5),
        Part(bulb, YELLOW, moderngl.TRIANGLES, 0.0),
        Part(boxes, GREEN, moderngl.LINES, 1e-5),
        Part(axes, GREY, moderngl.LINES, 1e-5),
        Part(np.zeros((0, 3)) if content.points is None else content.points, BLUE, moderngl.POINTS, 1e-5),
    ]


def _octahedron(center: np.ndarray, radius: float) -> np.ndarray:
    """The corners [24, 3] of the eight faces."""
    faces = [
        (np.array([sx, 0, 0]), np.array([0, sy, 0]), np.array([0, 0, sz]))
        for sx in (-1, 1)
        for sy in (-1, 1)
        for sz in (-1, 1)
    ]
    return center + radius * np.array(faces, float).reshape(-1, 3)
