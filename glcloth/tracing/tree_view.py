"""The acceleration structure as a picture: primitives with black edges, boxes of nodes in green.   [Mat section 4.3.3]

The lamp is light yellow, the axes grey, the primitives have their diffuse colour; nothing is shaded, everything is
z-buffered.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import moderngl
import numpy as np

from ..errors import InputError
from ..geometry.camera import Camera
from ..gpu import shader

YELLOW, GREEN, GREY, BLACK, PAPER = (
    (1.0, 0.95, 0.45),
    (0.05, 0.65, 0.1),
    (0.5, 0.5, 0.5),
    (0.0, 0.0, 0.0),
    (1.0, 1.0, 1.0),
)
EDGES = [(0, 1), (0, 2), (0, 4), (1, 3), (1, 5), (2, 3), (2, 6), (3, 7), (4, 5), (4, 6), (5, 7), (6, 7)]
OVERSAMPLING = 2
PART = 24_000  # vertices drawn at a time: whole triangles and whole lines


def box_lines(low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """The twelve edges [N, 12, 2, 3] of boxes with corners low, high [N, 3]."""
    corner = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)])
    points = low[:, None] + corner * (high - low)[:, None]
    return points[:, np.array(EDGES)]


def shown_nodes(tree: dict[str, np.ndarray], level: int | None) -> np.ndarray:
    """The numbers of the nodes to draw: those of one level, or (level None) the leaves that hold triangles.

    Raises InputError for a level that the tree does not have.
    """
    if level is None:
        return np.flatnonzero((tree["axis"] == 3) & (tree["count"] > 0))
    deepest = int(tree["depth"].max())
    if not 0 <= level <= deepest:
        raise InputError(f"tree level {level}: this tree has levels 0 to {deepest}; choose one of them, or leaves")
    return np.flatnonzero(tree["depth"] == level)


@dataclass(frozen=True)
class TreeContent:
    """What a picture of a structure shows, and from where.

    tree : `arrays()` of a structure that has boxes (kdtree or lbvh). positions : [T, 3, 3]; colors : [T, 3] diffuse, linear.
    lamp : position of the lamp. hidden : [T] bool, triangles to leave out (walls that would hide the rest).
    """

    tree: dict[str, np.ndarray]
    positions: np.ndarray
    colors: np.ndarray
    camera: Camera
    lamp: tuple[float, float, float] | None = None
    hidden: np.ndarray | None = None


class TreePicture:
    """Draws structures into a texture of its own, again and again: `texture`, RGBA, linear, bottom row first."""

    def __init__(self, ctx: moderngl.Context):
        self.ctx = ctx
        self.texture: moderngl.Texture | None = None
        self._program = shader.program(ctx, "passes/tracing/plain.vert", "passes/tracing/plain.frag")
        self._vertices = ctx.buffer(reserve=24, dynamic=True)
        self._array = ctx.vertex_array(self._program, [(self._vertices, "3f 3f", "position", "vertex_color")])
        self.boxes = 0
        self._target: moderngl.Framebuffer | None = None
        self._depth: moderngl.Renderbuffer | None = None

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
        tree, positions, lamp = content.tree, content.positions, content.lamp
        if "low" not in tree:
            raise InputError("brute force has no tree to show; choose kdtree or lbvh")
        nodes = shown_nodes(tree, level)
        low, high = tree["low"][nodes].astype(float), tree["high"][nodes].astype(float)
        bound_low, bound_high = positions.min((0, 1)).astype(float), positions.max((0, 1)).astype(float)
        low, high = np.maximum(low, bound_low), np.minimum(high, bound_high)
        boxes = box_lines(low, high).reshape(-1, 3)
        length = float(np.linalg.norm(bound_high - bound_low))
        axes = np.array([[[0, 0, 0], axis] for axis in 0.5 * length * np.eye(3)]).reshape(-1, 3)
        bulb = np.zeros((0, 3)) if lamp is None else _octahedron(np.array(lamp, float), 0.02 * length)
        keep = np.ones(len(positions), bool) if content.hidden is None else ~np.asarray(content.hidden)
        triangles = positions[keep].reshape(-1, 3)
        tints = np.repeat(np.asarray(content.colors)[keep], 3, 0)
        edges = triangles.reshape(-1, 3, 3)[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 3)
        every = np.concatenate([positions.reshape(-1, 3), boxes, axes, bulb])
        near, far = content.camera.depth_range(every.min(0), every.max(0))
        self._reserve(size)
        self._program["clip_from_world"].write(content.camera.clip_from_world(size, near, far).T.astype("f4").tobytes())
        self._target.use()
        self._target.clear(*PAPER, 1.0)
        self.boxes = len(nodes)
        for points, tint, mode, nearer in (
            (triangles, tints, moderngl.TRIANGLES, 0.0),
            (edges, BLACK, moderngl.LINES, 2e-5),
            (bulb, YELLOW, moderngl.TRIANGLES, 0.0),
            (boxes, GREEN, moderngl.LINES, 1e-5),
            (axes, GREY, moderngl.LINES, 1e-5),
        ):
            for first in range(0, len(points), PART):
                part = slice(first, first + PART)
                self._put(points[part], tint[part] if tint is tints else tint, mode, nearer)
                yield

    def _put(self, points: np.ndarray, tint, mode: int, nearer: float) -> None:
        data = np.empty((len(points), 6), np.float32)
        data[:, :3], data[:, 3:] = points, tint
        if self._vertices.size < data.nbytes:
            self._vertices.orphan(24 * PART)
        self._vertices.write(data)
        self._program["nearer"].value = nearer
        # Between two parts others may have drawn elsewhere.
        self._target.use()
        self.ctx.viewport = (0, 0, *self._target.size)
        self.ctx.enable_only(moderngl.DEPTH_TEST)
        self._array.render(mode, vertices=len(points))
        self.ctx.enable_only(moderngl.NOTHING)
        # moderngl binds the last framebuffer back after making a new one; it must not be a deleted one.
        self.ctx.detect_framebuffer(0).use()

    def _reserve(self, size: tuple[int, int]) -> None:
        if self.texture is not None and self.texture.size == tuple(size):
            return
        self._free()
        self.texture = self.ctx.texture(size, 4, dtype="f4")
        self._depth = self.ctx.depth_renderbuffer(size)
        self._target = self.ctx.framebuffer([self.texture], self._depth)

    def _free(self) -> None:
        self.ctx.detect_framebuffer(0).use()
        for thing in (self._target, self._depth, self.texture):
            if thing is not None:
                thing.release()
        self.texture = self._depth = self._target = None

    def release(self) -> None:
        """Free the GPU's memory."""
        self._free()
        for thing in (self._array, self._vertices, self._program):
            thing.release()


def draw_tree(ctx, content: TreeContent, size: tuple[int, int], level: int | None = None) -> np.ndarray:
    """Draw a structure and the triangles that it holds, once; parameters and errors as for TreePicture.steps.

    Returns float32 [H, W, 3], linear, top row first.
    """
    k = OVERSAMPLING
    drawn = (size[0] * k, size[1] * k)
    picture = TreePicture(ctx)
    try:
        picture.draw(content, drawn, level)
        pixels = np.frombuffer(picture.texture.read(), np.float32).reshape(drawn[1], drawn[0], 4)[::-1, :, :3]
        return pixels.reshape(size[1], k, size[0], k, 3).mean((1, 3)).astype(np.float32)
    finally:
        picture.release()


def _octahedron(center: np.ndarray, radius: float) -> np.ndarray:
    """The corners [24, 3] of the eight faces."""
    faces = [
        (np.array([sx, 0, 0]), np.array([0, sy, 0]), np.array([0, 0, sz]))
        for sx in (-1, 1)
        for sy in (-1, 1)
        for sz in (-1, 1)
    ]
    return center + radius * np.array(faces, float).reshape(-1, 3)
