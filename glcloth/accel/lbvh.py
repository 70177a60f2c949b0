"""A bounding volume hierarchy from sorted Morton codes, rebuilt every frame: what one would take today.   [Karras 2012]"""

from __future__ import annotations

import time

import numpy as np

from ..gpu import shader
from ..gpu.buffers import TextureBuffer
from ..gpu.layout import shared
from .triangles import Triangles

CONSTANTS, _ = shared("trace/shared.glsl")
LANES = 512
LEAF = 0x80000000
CODE_BITS = 30
# Texels per triangle, and the format.
SIZES = {
    "keys_a": (1, "rg32ui"), "keys_b": (1, "rg32ui"), "tree": (1, "rgba32ui"), "parents": (2, "r32ui"),
    "boxes": (4, "rgba32ui"), "arrivals": (1, "r32ui"), "bvh_nodes": (4, "rgba32ui"), "leaf_triangles": (1, "r32ui"),
    "leaf_corners": (3, "rgba32ui"),
}  # fmt: skip
UNITS = {
    "keys": 1, "histogram": 2, "begins": 3, "tree": 5, "parents": 6, "boxes": 7, "leaf_triangles": 9,
}  # fmt: skip
BINDINGS = {
    "keys": 1, "histogram": 2, "begins": 3, "lanes": 4, "tree": 5, "parents": 6, "boxes": 7, "arrivals": 8,
    "bvh_nodes": 11, "leaf_triangles": 12, "leaf_corners": 13,
}  # fmt: skip


class Lbvh:
    """A bounding volume hierarchy of `Triangles` on the GPU, behind the same interface as KdTree."""

    name = "lbvh"
    source = "inputs/accel/lbvh.glsl"
    settles = False

    def __init__(self, ctx):
        self.ctx = ctx
        self._programs: dict[str, object] = {}
        self._buffers = {name: TextureBuffer(ctx, 64, texel) for name, (_, texel) in SIZES.items()}
        self._buffers |= {name: TextureBuffer(ctx, 64, "r32ui") for name in ("histogram", "begins")}
        self._buffers["lanes"] = TextureBuffer(ctx, 32 * LANES)
        self._count = 0
        self.triangles: Triangles | None = None  # that it was built of
        self.timings: dict[str, float] = {}
        self.node_count = self.leaf_ref_count = 0

    def build(self, triangles: Triangles) -> None:
        """Build the hierarchy of the triangles as they are now."""
        self.triangles = triangles
        n = self._count = self.leaf_ref_count = triangles.count
        self.node_count = max(n - 1, 1)
        laps = [("", time.perf_counter())]

        def lap(stage: str) -> None:
            laps.append((stage, time.perf_counter()))

        for name, (texels, _) in SIZES.items():
            self._buffers[name].reserve(max(n, 2) * texels * self._buffers[name].texel_bytes)
        if n == 0:
            self._buffers["bvh_nodes"].write(_node(0))
            return
        triangles.corners.bind(0)
        triangles.attributes.bind(10)
        self._write("lanes")
        self._run("lbvh_bounds", LANES, triangle_count=n, lanes=LANES)
        lanes = np.frombuffer(self._buffers["lanes"].buffer.read(), np.float32).reshape(LANES, 2, 4)[:, :, :3]
        low, high = tuple(map(float, lanes[:, 0].min(0))), tuple(map(float, lanes[:, 1].max(0)))
        self._write("keys", "keys_a")
        self._run("lbvh_codes", n, triangle_count=n, scene_low=low, scene_high=high)
        lap("codes")
        self._sort(n)
        lap("sort")
        self._read("keys", "keys_a")
        self._write("tree")
        self._write("parents")
        self._run("lbvh_tree", n - 1, key_count=n)
        lap("tree")
        self._buffers["arrivals"].write(bytes(4 * n))
        self._read("tree")
        self._read("parents")
        self._write("boxes")
        self._write("arrivals")
        self._run("lbvh_boxes", n, key_count=n, padding=triangles.padding)
        lap("boxes")
        self._read("boxes")
        self._write("bvh_nodes")
        self._write("leaf_triangles")
        self._run("lbvh_emit", n, key_count=n)
        if n == 1:
            self._buffers["bvh_nodes"].write(_node(1))
        self._read("leaf_triangles")
        self._write("leaf_corners")
        self._run("lbvh_leaves", n, leaf_ref_count=n)
        lap("emit")
        self.timings = {name: 1000 * (end - laps[k][1]) for k, (name, end) in enumerate(laps[1:])}

    def _sort(self, n: int) -> None:
        """Sort the keys by their codes, digit by digit; they end in keys_a."""
        bits = CONSTANTS["SORT_BITS"]
        chunks = -(-n // CONSTANTS["SORT_CHUNK"])
        entries = chunks << bits
        for name in ("histogram", "begins"):
            self._buffers[name].reserve(4 * entries)
        source, target = "keys_a", "keys_b"
        digits = -(-CODE_BITS // bits)
        for digit in range(digits + digits % 2):
            every = {"key_count": n, "chunk_count": chunks, "shift": bits * digit}
            self._read("keys", source)
            self._write("histogram")
            self._run("sort_count", chunks, 8, **every)
            self._read("histogram")
            self._write("begins")
            self._run("sort_scan", 64, entry_count=entries)
            self._read("begins")
            self._write("keys", target)
            self._run("sort_place", chunks, 8, **every)
            source, target = target, source

    def _read(self, name: str, buffer: str | None = None) -> None:
        self._buffers[buffer or name].bind(UNITS[name])

    def _write(self, name: str, buffer: str | None = None) -> None:
        self._buffers[buffer or name].buffer.bind_to_storage_buffer(BINDINGS[name])

    def _run(self, stage: str, invocations: int, group: int = 64, **uniforms) -> None:
        """Dispatch one pass and make what it wrote visible to all that follows."""
        if invocations <= 0:
            return
        if stage not in self._programs:
            self._programs[stage] = shader.compute(self.ctx, f"passes/accel/{stage}.comp")
        shader.set_uniforms(self._programs[stage], **uniforms)
        self._programs[stage].run(-(-invocations // group))
        self.ctx.memory_barrier()

    def inputs(self) -> dict:
        """What inputs/accel/lbvh.glsl reads."""
        return {name: self._buffers[name] for name in ("bvh_nodes", "leaf_corners")}

    def bind(self, program) -> None:
        """Bind what inputs/accel/lbvh.glsl reads."""
        self._buffers["bvh_nodes"].bind(8)
        self._buffers["leaf_corners"].bind(9)

    def chunks(self):
        """The uniforms of each dispatch that one query takes."""
        yield {}

    def arrays(self) -> dict[str, np.ndarray]:
        """The hierarchy as NumPy arrays: axis [N] (3 = leaf, 0 = inner), left, right, first, count, low, high, depth of
        the nodes that a ray can come to, and the triangles [T] in leaf order."""
        data = np.frombuffer(self._buffers["bvh_nodes"].buffer.read(64 * self.node_count), np.uint32).reshape(
            -1, 2, 2, 4
        )
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
        triangles = np.frombuffer(self._buffers["leaf_triangles"].buffer.read(4 * max(self._count, 1)), np.uint32)
        tree["triangles"] = triangles[: self._count].astype(int)
        return tree

    def release(self) -> None:
        """Free the GPU's memory."""
        for thing in (*self._buffers.values(), *self._programs.values()):
            thing.release()


def _node(count: int) -> np.ndarray:
    """The node of a scene of no triangle or one: the left child a leaf of it, the right one a box that nothing enters."""
    full, empty = np.float32([-3e38] * 3), np.float32([3e38] * 3)
    node = np.zeros((2, 2, 4), np.uint32)
    node[0, 0, :3], node[0, 1, :3] = (
        (full.view(np.uint32), (-full).view(np.uint32)) if count else (empty.view(np.uint32), (-empty).view(np.uint32))
    )
    node[1, 0, :3], node[1, 1, :3] = empty.view(np.uint32), (-empty).view(np.uint32)
    node[:, 0, 3] = LEAF | count, LEAF
    return node
