"""The kd-tree that is built on the GPU every frame.   [Zhou, Hou, Wang, Guo 2008; paper B section 4.3.2]

Large nodes are split level by level, empty space first, then at the cheapest of LARGE_PLANES planes across each axis
by the surface area heuristic; small ones at the best of all faces of their triangles' boxes, with masks instead of
lists; then the nodes are written in preorder. Open in Zhou 2008 and chosen here: a step costs C_TS triangle tests;
a candidate plane must lie strictly inside its node; a triangle in the plane goes left, and boxes are padded so that it
goes both ways; large nodes that cannot be split well (their children would hold more than GROWTH_LIMIT times their
triangles) become leaves; no tree is deeper than the tracer's stack. Two triangles that share an edge are one to the
builder and the tracer. The numbers are in glsl/trace/shared.glsl.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import moderngl
import numpy as np

from ..errors import InputError
from ..gpu.buffers import Buffer, TextureBuffer
from ..gpu.layout import shared
from ..gpu.programs import programs
from ..progress import Stopwatch, drain
from .triangles import Triangles

CONSTANTS, _ = shared("trace/shared.glsl")
SMALL_SIZE = CONSTANTS["MASK_BITS"]  # the most triangles of a small node
LONGEST_LEAF = 60_000  # a loop over more triangles could end silently on a software rasteriser
# Invocations that share a large node: many while the nodes are few, so that every core has work.
LANE_BYTES = 16 * CONSTANTS["LANE_TEXELS"]
LANES_OF_ALL, FEWEST_LANES, MOST_LANES = 1024, 16, 128
LANE_REFS = 0xFFFF  # the most references that a lane can count (glsl/trace/split.glsl side_counts)
NODES_AT_FIRST, REFS_AT_FIRST = 3.0, 2.5  # for each pair of triangles: a first guess
# The buffers by their names in the passes (as texture, as block): texels per node, per reference, per reference in a leaf;
# texel format. Two lists of active nodes change places level by level.
BUFFERS = {
    "nodes Nodes": ("node", 4, "rgba32ui"), "active_nodes": ("node", 1, "r32ui"), "Active": ("node", 1, "r32ui"),
    "Sizes": ("node", 1, "rg32ui"), "places Places": ("node", 1, "rg32ui"), "tree_nodes TreeNodes": ("node", 1, "rg32ui"),
    "refs Refs": ("ref", 6, "rgba32ui"), "masks Masks": ("ref", 6, "rgba32ui"), "roots Roots": ("ref", 1, "rgba32ui"),
    "leaf_pairs LeafPairs": ("leaf", 1, "r32ui"), "leaf_corners LeafCorners": ("leaf", 4, "rgba32ui"),
    "lane_data Lanes": ("", 0, "rgba32ui"), "bounds": ("", 0, "r32ui"),
}  # fmt: skip


class _TooSmallError(Exception):
    """A buffer was too small for the tree; it is larger now."""


class KdTree:
    """A kd-tree of `Triangles` on the GPU (glcloth/accel/structure.py).

    After `build`: leaf_ref_count counts pairs of triangles; low and high (the root's box); growths, how often a buffer was
    too small so far.
    """

    source = "inputs/accel/kdtree.glsl"
    ordered_hits = True
    spatial_median = False  # whether large nodes are cut in the middle of their longest side, not where it costs least

    def __init__(self, ctx: moderngl.Context):
        self.ctx = ctx
        self._counters = Buffer(ctx, 4 * CONSTANTS["COUNTERS"])
        self._buffers: dict[str, TextureBuffer] = {}
        for names, (_, _, texel) in BUFFERS.items():
            buffer = TextureBuffer(ctx, 16, texel)
            self._buffers |= dict.fromkeys(names.split(), buffer)
        self._inputs: dict[str, Any] = {}  # of the passes that build
        self._capacity = {"node": 0, "ref": 0, "leaf": 0}
        self.triangles: Triangles | None = None
        self.timings: dict[str, float] = {}
        self.growths = 0
        self.node_count = self.leaf_ref_count = self.root_count = self.large_levels = self.small_levels = 0
        self.low, self.high = np.zeros(3, np.float32), np.zeros(3, np.float32)

    # -- building ------------------------------------------------------------------------------------------------

    def build(self, triangles: Triangles) -> None:
        """Build the tree of the triangles as they are now; buffers that turn out too small grow, and it starts again.

        Raises InputError when more than 60,000 triangles lie so upon each other that no plane parts them.
        """
        drain(self.build_steps(triangles))

    def build_steps(self, triangles: Triangles) -> Iterator[None]:
        """As `build`, stage by stage, for a caller with other things to do in between."""
        self.triangles = triangles
        count, pairs = triangles.pairs()
        if count == 0:
            self._empty()
            return
        self._inputs = self._buffers | triangles.inputs() | {"pairs": pairs, "Counters": self._counters}
        self._reserve("node", int(NODES_AT_FIRST * count + 256))
        self._reserve("ref", max(int(REFS_AT_FIRST * count + 256), count))
        while True:
            try:
                yield from self._attempt(count, triangles.padding)
                return
            except _TooSmallError:
                self.growths += 1

    def _attempt(self, pair_count: int, padding: float) -> Iterator[None]:
        """One build. Raises _TooSmallError when there was not enough room; there is more then."""
        clock = Stopwatch()
        counters = np.zeros(CONSTANTS["COUNTERS"], np.uint32)
        counters[CONSTANTS["NODE_COUNT"]] = 1
        self._counters.write(counters)
        self._run("passes/accel/kdtree_init.comp", pair_count, pair_count=pair_count, padding=padding)
        self._swap_active()
        clock.lap("init")
        generations = [0, 1]  # where each begins among the nodes
        self.large_levels = self._split_large(padding, generations)
        clock.lap("large")
        yield
        clock.resume()
        small_base = 2 * self._capacity["ref"]  # where the references of small nodes begin
        # A work group each.
        masks = "passes/accel/kdtree_masks.comp"
        self._run(masks, 16 * self.root_count, root_count=self.root_count, small_base=small_base)
        roots = self._next_level(generations)
        clock.lap("masks")
        self.small_levels = self._split_small(roots, small_base, generations)
        clock.lap("small")
        yield
        clock.resume()
        self._write_tree(sorted(set(generations)), clock)
        self.timings = clock.ms

    def _split_large(self, padding: float, generations: list[int]) -> int:
        """Split the large nodes level by level; the number of levels."""
        refs = self._capacity["ref"]
        fewest = max(FEWEST_LANES, -(-refs // LANE_REFS))
        active, level = 1, 0
        while active:
            lanes = max(min(LANES_OF_ALL >> (active - 1).bit_length(), MOST_LANES), fewest)
            self._buffers["Lanes"].reserve(LANE_BYTES * lanes * active)
            shares = {"active_count": active, "lanes": lanes}
            self._run("passes/accel/kdtree_measure.comp", active * lanes, **shares)
            if level == 0:
                # Where the middle is, is known only now.
                self._run("passes/accel/kdtree_root.comp", 1, lanes=lanes)
                self._run("passes/accel/kdtree_measure.comp", active * lanes, **shares)
            self._run(
                "passes/accel/kdtree_divide.comp", active, level=level, small_size=SMALL_SIZE,
                node_capacity=self._capacity["node"], ref_capacity=refs, next_base=refs * ((level + 1) % 2),
                small_base=2 * refs, spatial_median=self.spatial_median, **shares,
            )  # fmt: skip
            self._run("passes/accel/kdtree_scatter.comp", active * lanes, padding=padding, **shares)
            active, level = self._next_level(generations), level + 1
        return level

    def _split_small(self, active: int, small_base: int, generations: list[int]) -> int:
        """Split the small nodes level by level; the number of levels."""
        level = 0
        while active:
            self._run(
                "passes/accel/kdtree_small.comp", active, active_count=active, level=level, small_base=small_base,
                node_capacity=self._capacity["node"],
            )  # fmt: skip
            active, level = self._next_level(generations), level + 1
        return level

    def _next_level(self, generations: list[int]) -> int:
        """Note the nodes that a level made, and go on to them; returns how many are active.

        Raises _TooSmallError, and InputError for too many triangles that no plane parts.
        """
        counters = np.frombuffer(self._counters.read(), np.uint32)
        needs = int(counters[CONSTANTS["NEED_NODES"]]), int(counters[CONSTANTS["NEED_REFS"]])
        if any(needs):
            for unit, need in zip(("node", "ref"), needs, strict=True):
                self._reserve(unit, need, spare=need // 2)
            raise _TooSmallError
        longest = int(counters[CONSTANTS["LONGEST_LEAF_COUNT"]])
        if longest > LONGEST_LEAF:
            raise InputError(
                f"kd-tree: {longest} triangles lie upon each other, expected at most {LONGEST_LEAF}; are they copies?"
            )
        generations.append(int(counters[CONSTANTS["NODE_COUNT"]]))
        self.root_count = int(counters[CONSTANTS["ROOT_COUNT"]])
        at = CONSTANTS["ACTIVE_COUNT"]
        assert CONSTANTS["NEXT_REF_COUNT"] == at + 1
        self._counters.write(bytes(8), offset=4 * at)
        self._swap_active()
        return int(counters[at])

    def _swap_active(self) -> None:
        """Let the two lists of active nodes change places."""
        names = self._inputs
        names["active_nodes"], names["Active"] = names["Active"], names["active_nodes"]

    def _write_tree(self, generations: list[int], clock: Stopwatch) -> None:
        """Write the nodes in preorder, and the triangles of the leaves."""
        self.node_count = generations[-1]
        self._buffers["bounds"].write(np.array(generations, np.uint32))
        self._run("passes/accel/kdtree_order.comp", 1, generation_count=len(generations) - 1)
        counted = self._counters.read(4, offset=4 * CONSTANTS["LEAF_REF_COUNT"])
        self.leaf_ref_count = int(np.frombuffer(counted, np.uint32)[0])
        clock.lap("order")
        self._reserve("leaf", self.leaf_ref_count)
        self._run("passes/accel/kdtree_emit.comp", self.node_count, node_count=self.node_count)
        self._run("passes/accel/kdtree_leaves.comp", self.leaf_ref_count, leaf_ref_count=self.leaf_ref_count)
        root = np.frombuffer(self._buffers["nodes"].read(32), np.float32)
        self.low, self.high = root[:3].copy(), root[4:7].copy()
        clock.lap("emit")

    def _empty(self) -> None:
        """The tree of no triangles: one leaf without any."""
        self._buffers["tree_nodes"].write(np.array([0, 3], np.uint32))
        self.node_count, self.leaf_ref_count, self.root_count = 1, 0, 0
        self.low, self.high = np.zeros(3, np.float32), np.zeros(3, np.float32)
        self.timings = {}

    def _reserve(self, unit: str, need: int, spare: int = 0) -> None:
        """Make room for `need` nodes, references or references in leaves; where it grows, for `spare` more."""
        if need <= self._capacity[unit]:
            return
        self._capacity[unit] = max(need + spare, 64)
        for names, (per, texels, _) in BUFFERS.items():
            if per == unit:
                buffer = self._buffers[names.split()[0]]
                buffer.reserve(self._capacity[unit] * texels * buffer.texel_bytes)

    def _run(self, path: str, items: int, **own: Any) -> None:
        programs(self.ctx).compute(path).run(items, self._inputs, **own)

    # -- tracing and looking -------------------------------------------------------------------------------------

    def inputs(self) -> dict[str, Any]:
        """The inputs of inputs/accel/kdtree.glsl, by name."""
        tree = {name: self._buffers[name] for name in ("tree_nodes", "leaf_corners")}
        return tree | {"scene_low": self.low, "scene_high": self.high}

    def chunks(self) -> Iterator[dict[str, int]]:
        """The uniforms of each dispatch that one query takes."""
        yield {}

    def arrays(self) -> dict[str, np.ndarray]:
        """The tree as NumPy arrays, nodes in preorder.

        axis [N] int (3 = leaf), split [N] float32, left, right [N] int (children), first, count [N] int (of a leaf, in
        `triangles`), pairs [N] int (what a leaf holds as the builder counts), low, high [N, 3] float32 (the node's box),
        depth [N] int, triangles [R] int.
        """
        nodes = np.frombuffer(self._buffers["tree_nodes"].read(8 * self.node_count), np.uint32).reshape(-1, 2)
        refs = self._buffers["leaf_pairs"].read(4 * self.leaf_ref_count)
        pairs = np.frombuffer(refs, np.uint32).astype(int)
        # Where each pair begins in the list of triangles.
        begins = np.concatenate([[0], np.cumsum(1 + (pairs & 1))])
        triangles = np.repeat(pairs >> 1, 1 + (pairs & 1))
        triangles[begins[:-1][(pairs & 1) == 1] + 1] += 1
        axis, payload = (nodes[:, 1] & 3).astype(int), (nodes[:, 1] >> 2).astype(int)
        leaf = axis == 3
        tree = {
            "axis": axis,
            "split": np.where(leaf, 0, nodes[:, 0].view(np.float32)),
            "left": np.where(leaf, -1, np.arange(len(axis)) + 1),
            "right": np.where(leaf, -1, payload),
            "first": begins[np.where(leaf, nodes[:, 0], 0).astype(int)],
            "count": begins[np.where(leaf, nodes[:, 0] + payload, 0).astype(int)]
            - begins[np.where(leaf, nodes[:, 0], 0).astype(int)],
            "pairs": np.where(leaf, payload, 0),
            "triangles": triangles,
        }
        low, high = np.zeros((len(axis), 3), np.float32), np.zeros((len(axis), 3), np.float32)
        depth = np.zeros(len(axis), int)
        low[0], high[0] = self.low, self.high
        level = np.array([0])
        while len(level):
            level = level[~leaf[level]]
            for child, side in ((tree["left"][level], high), (tree["right"][level], low)):
                low[child], high[child], depth[child] = low[level], high[level], depth[level] + 1
                side[child, axis[level]] = tree["split"][level]
            level = np.concatenate([tree["left"][level], tree["right"][level]])
        return tree | {"low": low, "high": high, "depth": depth}

    def release(self) -> None:
        """Free the GPU's memory."""
        for thing in (*set(self._buffers.values()), self._counters):
            thing.release()


class MedianKdTree(KdTree):
    """As paper B and Zhou et al. 2008 have it: large nodes are cut at the spatial median."""

    spatial_median = True
