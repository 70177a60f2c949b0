"""A bounding volume hierarchy from sorted Morton codes, rebuilt every frame: the usual choice today.   [Karras 2012]"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import moderngl
import numpy as np

from ..gpu.buffers import TextureBuffer
from ..gpu.layout import shared
from ..gpu.programs import programs
from ..progress import Stopwatch, drain
from .triangles import Triangles

CONSTANTS, _ = shared("trace/shared.glsl")
LANES = 512
LEAF = 0x80000000
CODE_BITS = 30
# The buffers by their names in the passes (as texture, as block): texels per triangle, and their format. Two lists of keys
# change places digit by digit.
BUFFERS = {
    "keys": (1, "rg32ui"), "Keys": (1, "rg32ui"), "tree Tree": (1, "rgba32ui"), "parents Parents": (2, "r32ui"),
    "boxes Boxes": (4, "rgba32ui"), "Arrivals": (1, "r32ui"), "bvh_nodes BvhNodes": (4, "rgba32ui"),
    "leaf_triangles LeafTriangles": (1, "r32ui"), "leaf_corners LeafCorners": (3, "rgba32ui"),
    "histogram Histogram": (0, "r32ui"), "begins Begins": (0, "r32ui"), "Lanes": (0, "rgba32f"),
}  # fmt: skip

OF_KEYS = tuple(f"passes/accel/lbvh_{name}.comp" for name in ("codes", "boxes", "emit"))


class Lbvh:
    """A bounding volume hierarchy of `Triangles` on the GPU (glcloth/accel/structure.py)."""

    source = "inputs/accel/lbvh.glsl"
    ordered_hits = False

    def __init__(self, ctx: moderngl.Context):
        self.ctx = ctx
        self._buffers: dict[str, TextureBuffer] = {}
        for names, (_, texel) in BUFFERS.items():
            buffer = TextureBuffer(ctx, 64, texel)
            self._buffers |= dict.fromkeys(names.split(), buffer)
        self._buffers["Lanes"].reserve(32 * LANES)
        self._inputs: dict[str, Any] = {}  # of the passes that build
        self._defines: dict[str, int] = {}  # of those that read what a key stands for
        self.triangles: Triangles | None = None
        self.timings: dict[str, float] = {}
        self.node_count = self.leaf_ref_count = 0

    def build(self, triangles: Triangles) -> None:
        """Build the hierarchy of the triangles as they are now."""
        drain(self.build_steps(triangles))

    unread = None

    def fits(self, data: bytes) -> bool:
        """It always does: its size is known before."""
        return True

    def build_steps(self, triangles: Triangles, later: bool = False) -> Iterator[None]:
        """As `build`, in steps, for a caller with other things to do in between."""
        self.triangles = triangles
        pieces = triangles.pieces
        n = self.leaf_ref_count = triangles.count if pieces is None else pieces[0]
        self.node_count = max(n - 1, 1)
        if n == 0:
            self._buffers["bvh_nodes"].write(_node(0))
            return
        for names, (texels, _) in BUFFERS.items():
            buffer = self._buffers[names.split()[0]]
            buffer.reserve(max(n, 2) * texels * buffer.texel_bytes)
        self._inputs = self._buffers | triangles.inputs() | ({} if pieces is None else {"pieces": pieces[1]})
        self._defines = {} if pieces is None else {"PIECES": 1}
        clock = Stopwatch()
        self._write_codes(n)
        clock.lap("codes")
        self._sort(n)
        clock.lap("sort")
        yield
        clock.resume()
        self._run("passes/accel/lbvh_tree.comp", n - 1, key_count=n)
        clock.lap("tree")
        self._buffers["Arrivals"].write(bytes(4 * n))
        self._run("passes/accel/lbvh_boxes.comp", n, key_count=n, padding=triangles.padding)
        clock.lap("boxes")
        self._run("passes/accel/lbvh_emit.comp", n, key_count=n)
        if n == 1:
            self._buffers["bvh_nodes"].write(_node(1))
        self._run("passes/accel/lbvh_leaves.comp", n, leaf_ref_count=n)
        clock.lap("emit")
        self.timings = clock.ms

    def _write_codes(self, n: int) -> None:
        """Write the Morton codes of the triangles."""
        assert self.triangles is not None
        self._run("passes/accel/lbvh_bounds.comp", LANES, triangle_count=self.triangles.count, lanes=LANES)
        lanes = np.frombuffer(self._buffers["Lanes"].read(32 * LANES), np.float32).reshape(LANES, 2, 4)[:, :, :3]
        low, high = lanes[:, 0].min(0), lanes[:, 1].max(0)
        self._run("passes/accel/lbvh_codes.comp", n, key_count=n, scene_low=low, scene_high=high)
        self._swap_keys()

    def _sort(self, n: int) -> None:
        """Sort the keys by their codes, digit by digit."""
        bits = CONSTANTS["SORT_BITS"]
        chunks = -(-n // CONSTANTS["SORT_CHUNK"])
        entries = chunks << bits
        for name in ("histogram", "begins"):
            self._buffers[name].reserve(4 * entries)
        for shift in range(0, CODE_BITS, bits):
            digit = {"key_count": n, "chunk_count": chunks, "shift": shift}
            self._run("passes/accel/sort_count.comp", chunks, **digit)
            self._run("passes/accel/sort_scan.comp", 1, entry_count=entries)
            self._run("passes/accel/sort_place.comp", chunks, **digit)
            self._swap_keys()

    def _swap_keys(self) -> None:
        """Let the two lists of keys change places."""
        names = self._inputs
        names["keys"], names["Keys"] = names["Keys"], names["keys"]

    def _run(self, path: str, items: int, **own: Any) -> None:
        defines = self._defines if path in OF_KEYS else None
        programs(self.ctx).compute(path, defines).run(items, self._inputs, **own)

    def inputs(self) -> dict[str, Any]:
        """The inputs of inputs/accel/lbvh.glsl, by name."""
        return {name: self._buffers[name] for name in ("bvh_nodes", "leaf_corners")}

    def chunks(self) -> Iterator[dict[str, int]]:
        """The uniforms of each dispatch that one query takes."""
        yield {}

    def arrays(self) -> dict[str, np.ndarray]:
        """The hierarchy as NumPy arrays: axis [N] (3 = leaf, 0 = inner), left, right, first, count, low, high, depth of
        the nodes that a ray can come to, and the triangles [T] in leaf order."""
        nodes = self._buffers["bvh_nodes"].read(64 * self.node_count)
        data = np.frombuffer(nodes, np.uint32).reshape(-1, 2, 2, 4)
        rows: list[list] = []
        todo = [(0, np.full(3, -np.inf), np.full(3, np.inf), 0, -1, 0)]
        while todo:
            ref, low, high, depth, parent, side = todo.pop()
            if parent >= 0:
                rows[parent][1 + side] = len(rows)
            leaf = ref & LEAF
            rows.append(
                [3, -1, -1, (ref & ~LEAF) >> 3, ref & 7, low, high, depth]
                if leaf
                else [0, -1, -1, 0, 0, low, high, depth]
            )
            if not leaf:
                at = len(rows) - 1
                for k in (0, 1):
                    box = np.ascontiguousarray(data[ref, k, :, :3]).view(np.float32)
                    if (box[0] <= box[1]).all():
                        todo.append((int(data[ref, k, 0, 3]), box[0], box[1], depth + 1, at, k))
        names = ("axis", "left", "right", "first", "count", "low", "high", "depth")
        tree = {name: np.array(column) for name, column in zip(names, zip(*rows, strict=True), strict=True)}
        order = self._buffers["leaf_triangles"].read(4 * self.leaf_ref_count)
        tree["triangles"] = np.frombuffer(order, np.uint32).astype(int)
        return tree

    def release(self) -> None:
        """Free the GPU's memory."""
        for buffer in set(self._buffers.values()):
            buffer.release()


def _node(count: int) -> np.ndarray:
    """The node of a scene of no triangle or one: the left child a leaf of it, the right one a box that nothing enters."""
    empty = np.full(3, 3e38, np.float32)
    node = np.zeros((2, 2, 4), np.uint32)
    node[:, 0, :3], node[:, 1, :3] = empty.view(np.uint32), (-empty).view(np.uint32)
    if count:
        node[0, :, :3] = node[0, ::-1, :3].copy()
    node[:, 0, 3] = LEAF | count, LEAF
    return node
