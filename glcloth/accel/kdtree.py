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

from collections.abc import Iterator, Mapping
from typing import Any, ClassVar

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
LARGE_REFS = 2 * SMALL_SIZE  # of a large node, about: a first guess
LONGEST_LEAF = 60_000  # a loop over more triangles could end silently on a software rasteriser
# Invocations that share a large node: many while the nodes are few, so that every core has work.
LANES_OF_ALL, FEWEST_LANES, MOST_LANES = 1024, 16, 128
LANE_REFS = 0xFFFF  # the most references that a lane can count (glsl/trace/split.glsl side_counts)
# The buffers by their names in the passes (as texture, as block): texels per node, per reference, per reference in a leaf, per
# lane; texel format. Two lists of active nodes change places level by level.
BUFFERS = {
    "nodes Nodes": ("node", 4, "rgba32ui"), "active_nodes": ("node", 1, "r32ui"), "Active": ("node", 1, "r32ui"),
    "Sizes": ("node", 1, "rg32ui"), "places Places": ("node", 1, "rg32ui"), "tree_nodes TreeNodes": ("node", 1, "rg32ui"),
    "refs Refs": ("ref", 6, "rgba32ui"), "masks Masks": ("ref", 6, "rgba32ui"), "roots Roots": ("ref", 1, "rgba32ui"),
    "leaf_pairs LeafPairs": ("leaf", 1, "r32ui"), "leaf_corners LeafCorners": ("leaf", 4, "rgba32ui"),
    "lane_data Lanes": ("lane", CONSTANTS["LANE_TEXELS"], "rgba32ui"),
}  # fmt: skip
NODE_GROUP = CONSTANTS["NODE_GROUP"]
ALL_LEVELS = CONSTANTS["LARGE_LEVELS"] + 1, CONSTANTS["SMALL_LEVELS"] + 1  # of large nodes and of small ones, at most
NOTHING: Mapping[str, Any] = {}


class _TooSmallError(Exception):
    """A buffer was too small for the tree; it is larger now."""


class KdTree:
    """A kd-tree of `Triangles` on the GPU (glcloth/accel/structure.py).

    After `build`: leaf_ref_count counts pairs of triangles; low and high (the root's box); growths, how often a buffer or
    the number of levels was too small so far.
    """

    source = "inputs/accel/kdtree.glsl"
    ordered_hits = True
    buffers = BUFFERS
    begin_pass, leaves_pass = "passes/accel/kdtree_init.comp", "passes/accel/kdtree_leaves.comp"
    # For each pair of triangles: a first guess.
    at_first: ClassVar[Mapping[str, float]] = {"node": 3.0, "ref": 2.5, "leaf": 3.5}
    step_cost: float = CONSTANTS["C_TS"]  # in tests of a pair
    margin = 0.0  # of empty space round the references of a node that is not cut off, m
    spatial_median = False  # whether large nodes are cut in the middle of their longest side, not where it costs least

    def __init__(self, ctx: moderngl.Context):
        self.ctx = ctx
        self._counters = Buffer(ctx, 4 * CONSTANTS["COUNTERS"])
        self._buffers: dict[str, TextureBuffer] = {}
        for names, (_, _, texel) in self.buffers.items():
            buffer = TextureBuffer(ctx, 16, texel)
            self._buffers |= dict.fromkeys(names.split(), buffer)
        self._buffers |= dict.fromkeys(("tree_box", "TreeBox"), TextureBuffer(ctx, 32, "rgba32ui"))
        self._inputs: dict[str, Any] = {}  # of the passes that build
        self._capacity = {"node": 0, "ref": 0, "leaf": 0, "lane": 0}
        self._levels = ALL_LEVELS  # that the next build dispatches
        self._pair_count = 0
        self._open: tuple[int, int] | None = None  # levels of a build whose counters nobody has read
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

    def build_steps(self, triangles: Triangles, later: bool = False) -> Iterator[None]:
        """As `build`, stage by stage, for a caller with other things to do in between.

        later : where a tree of so many triangles was built before, the CPU does not wait to see whether this one had room:
            `unread` is to be read with what else is read of the frame, and given to `fits`
        """
        self.triangles = triangles
        count, pairs = triangles.pairs()
        yield from self._steps(count, triangles.inputs() | {"pairs": pairs}, triangles.padding, later)

    @property
    def unread(self) -> Buffer | None:
        """The counters of a build that nobody has seen to have had room; None: there is none."""
        return None if self._open is None else self._counters

    def fits(self, data: bytes) -> bool:
        """Whether the tree whose `unread` counters these are had room. Else there is more now, and it is to be built anew.

        Raises InputError as `build`.
        """
        assert self._open is not None, "there are no unread counters"
        counters, levels, self._open = np.frombuffer(data, np.uint32), self._open, None
        leaf_refs = int(counters[CONSTANTS["NEED_LEAF_REFS"]])
        try:
            self._check(counters, levels)
        except _TooSmallError:
            self.growths += 1
            return False
        if leaf_refs:
            self._reserve("leaf", leaf_refs, spare=leaf_refs // 4)
            self.growths += 1
            return False
        self._note(counters)
        return True

    def _steps(self, count: int, inputs: Mapping[str, Any], padding: float, later: bool = False) -> Iterator[None]:
        """Build the tree of so many references, which `begin_pass` makes of its inputs."""
        self._open = None
        if count == 0:
            self._empty()
            return
        self._inputs = self._buffers | dict(inputs) | {"Counters": self._counters}
        self._inputs |= {"most_groups": programs(self.ctx).most_groups, "longest_leaf": LONGEST_LEAF}
        if count != self._pair_count:  # another scene
            self._pair_count, self._levels, later = count, ALL_LEVELS, False
        for unit, times in self.at_first.items():
            self._reserve(unit, max(int(times * count + 256), count if unit == "ref" else 0))
        while True:
            try:
                yield from self._attempt(count, padding, later)
                return
            except _TooSmallError:
                self.growths += 1

    def _attempt(self, pair_count: int, padding: float, later: bool) -> Iterator[None]:
        """One build, with as many levels as the last one had and one more; the CPU waits once, at the end, or `later`.

        Raises _TooSmallError when there was not enough room, or levels; there is more then.
        """
        clock = Stopwatch()
        refs, level_counts = self._capacity["ref"], self._levels
        first_lanes = max(min(LANES_OF_ALL, MOST_LANES), -(-pair_count // LANE_REFS))
        # A level has as many lanes for each node as its largest one needs; where that is more, the buffer grows.
        self._reserve("lane", max(LANES_OF_ALL + FEWEST_LANES * (refs // LARGE_REFS + 1), first_lanes))
        small = {
            "small_base": 2 * refs,  # where the references of small nodes begin
            "node_capacity": self._capacity["node"],
            "column_nodes": self._begin_counters(first_lanes),
        }
        self._run(self.begin_pass, pair_count, pair_count=pair_count, padding=padding)
        self._swap_active()
        clock.lap("init")
        self._split_large(level_counts[0], padding, small)
        clock.lap("large")
        yield
        clock.resume()
        self._run_counted("passes/accel/kdtree_masks.comp", "MASK_GROUPS", small)
        self._swap_active()
        clock.lap("masks")
        for level in range(level_counts[1]):
            self._run_counted(
                "passes/accel/kdtree_small.comp",
                "SMALL_GROUPS",
                small,
                skip=3 * level,
                level=level,
                step_cost=self.step_cost,
            )
            self._swap_active()
        clock.lap("small")
        yield
        clock.resume()
        self._write_tree(level_counts, clock, later)
        self.timings = clock.ms

    def _begin_counters(self, lanes: int) -> int:
        """Write the counters of a tree that is its root, which `lanes` invocations share; the nodes of a column of work
        groups of a level of small ones."""
        most = programs(self.ctx).most_groups
        counters = np.zeros(CONSTANTS["COUNTERS"], np.uint32)
        for name, value in {"NODE_COUNT": 1, "ACTIVE_NOW": 1, "LANES_NOW": lanes, "LARGE_USED": 1}.items():
            counters[CONSTANTS[name]] = value
        counters[CONSTANTS["GENERATIONS"] + 1] = 1
        for name, groups in (("LANE_GROUPS", -(-lanes // NODE_GROUP)), ("NODE_GROUPS", 1)):
            counters[CONSTANTS[name] : CONSTANTS[name] + 3] = groups, 1, 1
        rows = -(-self._capacity["node"] // (NODE_GROUP * most))
        at = CONSTANTS["SMALL_GROUPS"]
        counters[at:].reshape(-1, 3)[:, 1:] = rows, 1
        self._counters.write(counters)
        return rows * NODE_GROUP

    def _split_large(self, levels: int, padding: float, small: dict[str, int]) -> None:
        """Split the large nodes level by level."""
        refs = self._capacity["ref"]
        for level in range(levels):
            self._run_counted("passes/accel/kdtree_measure.comp", "LANE_GROUPS")
            if level == 0:
                # Where the middle is, is known only now.
                self._run("passes/accel/kdtree_root.comp", 1)
                self._run_counted("passes/accel/kdtree_measure.comp", "LANE_GROUPS")
            self._run_counted(
                "passes/accel/kdtree_divide.comp", "NODE_GROUPS", small, level=level, small_size=SMALL_SIZE,
                ref_capacity=refs, next_base=refs * ((level + 1) % 2), spatial_median=self.spatial_median, margin=self.margin,
            )  # fmt: skip
            self._run_counted("passes/accel/kdtree_scatter.comp", "LANE_GROUPS", padding=padding)
            self._run(
                "passes/accel/kdtree_level.comp", 1, level=level + 1, lanes_of_all=LANES_OF_ALL,
                fewest_lanes=FEWEST_LANES, most_lanes=MOST_LANES, lane_refs=LANE_REFS, lane_capacity=self._capacity["lane"],
            )  # fmt: skip
            self._swap_active()

    def _swap_active(self) -> None:
        """Let the two lists of active nodes change places."""
        names = self._inputs
        names["active_nodes"], names["Active"] = names["Active"], names["active_nodes"]

    def _write_tree(self, levels: tuple[int, int], clock: Stopwatch, later: bool) -> None:
        """Write the nodes in preorder, and the triangles of the leaves; then, or `later`, see how it went.

        Raises _TooSmallError, and InputError for too many triangles that no plane parts.
        """
        self._run(
            "passes/accel/kdtree_order.comp", 1, large_levels=levels[0], small_levels=levels[1],
            leaf_capacity=self._capacity["leaf"],
        )  # fmt: skip
        clock.lap("order")
        self._emit()
        if later:
            self._open = levels
            clock.lap("emit")
            return
        counters = np.frombuffer(self._counters.read(), np.uint32)
        self._check(counters, levels)
        leaf_refs = int(counters[CONSTANTS["NEED_LEAF_REFS"]])
        if leaf_refs:
            self._reserve("leaf", leaf_refs, spare=leaf_refs // 4)
            for name, items in (("EMIT_GROUPS", counters[CONSTANTS["NODE_COUNT"]]), ("LEAF_GROUPS", leaf_refs)):
                groups = -(-int(items) // NODE_GROUP)
                rows = -(-groups // programs(self.ctx).most_groups)
                self._counters.write(np.array([-(-groups // rows), rows, 1], np.uint32), offset=4 * CONSTANTS[name])
            self._emit()
        self._note(counters)
        clock.lap("emit")

    def _emit(self) -> None:
        self._run_counted("passes/accel/kdtree_emit.comp", "EMIT_GROUPS")
        self._run_counted(self.leaves_pass, "LEAF_GROUPS")

    def _check(self, counters: np.ndarray, levels: tuple[int, int]) -> None:
        """Raise _TooSmallError where a buffer was too small or levels too few, InputError for too long a leaf."""
        needs = {unit: int(counters[CONSTANTS[f"NEED_{unit.upper()}S"]]) for unit in ("node", "ref", "lane")}
        longest = int(counters[CONSTANTS["LONGEST_LEAF_COUNT"]])
        if not any(needs.values()) and longest > LONGEST_LEAF:
            raise InputError(
                f"kd-tree: {longest} triangles lie upon each other, expected at most {LONGEST_LEAF}; are they copies?"
            )
        for unit, need in needs.items():
            self._reserve(unit, need, spare=need // 2)
        active = counters[CONSTANTS["ACTIVE_NOW"]], counters[CONSTANTS["SMALL_ACTIVE"] + levels[1]]
        if any(active):
            self._levels = ALL_LEVELS
        if any(needs.values()) or any(active):
            raise _TooSmallError

    def _note(self, counters: np.ndarray) -> None:
        """Keep what is to be known of a finished tree."""
        self.node_count, self.root_count, self.leaf_ref_count, self.large_levels = (
            int(counters[CONSTANTS[name]]) for name in ("NODE_COUNT", "ROOT_COUNT", "LEAF_REF_COUNT", "LARGE_USED")
        )
        at = CONSTANTS["SMALL_ACTIVE"]
        self.small_levels = int(np.count_nonzero(counters[at : at + ALL_LEVELS[1]]))
        spared = (self.large_levels + 1, max(self.small_levels, 1) + 1)
        self._levels = min(spared[0], ALL_LEVELS[0]), min(spared[1], ALL_LEVELS[1])
        box = counters[CONSTANTS["ROOT_BOX"] :][:6].view(np.float32)
        self.low, self.high = box[:3].copy(), box[3:].copy()

    def _empty(self) -> None:
        """The tree of no triangles: one leaf without any."""
        self._buffers["tree_nodes"].write(np.array([0, 3], np.uint32))
        self._buffers["tree_box"].write(np.zeros(8, np.float32))
        self.node_count, self.leaf_ref_count, self.root_count = 1, 0, 0
        self.low, self.high = np.zeros(3, np.float32), np.zeros(3, np.float32)
        self.timings = {}

    def _reserve(self, unit: str, need: int, spare: int = 0) -> None:
        """Make room for `need` nodes, references, references in leaves or lanes; where it grows, for `spare` more."""
        if need <= self._capacity[unit]:
            return
        self._capacity[unit] = max(need + spare, 64)
        for names, (per, texels, _) in self.buffers.items():
            if per == unit:
                buffer = self._buffers[names.split()[0]]
                buffer.reserve(self._capacity[unit] * texels * buffer.texel_bytes)

    def _run(self, path: str, items: int, **own: Any) -> None:
        programs(self.ctx).compute(path).run(items, self._inputs, **own)

    def _run_counted(
        self, path: str, groups: str, more: Mapping[str, Any] = NOTHING, skip: int = 0, **own: Any
    ) -> None:
        """Run a pass for as many work groups as the counters say from a name and `skip` numbers on."""
        where = 4 * (CONSTANTS[groups] + skip)
        programs(self.ctx).compute(path).run_indirect(self._counters, self._inputs, more, skip=where, **own)

    # -- tracing and looking -------------------------------------------------------------------------------------

    def inputs(self) -> dict[str, Any]:
        """The inputs of inputs/accel/kdtree.glsl, by name."""
        return {name: self._buffers[name] for name in ("tree_nodes", "leaf_corners", "tree_box")}

    def chunks(self) -> Iterator[dict[str, int]]:
        """The uniforms of each dispatch that one query takes."""
        yield {}

    def arrays(self) -> dict[str, np.ndarray]:
        """The tree as NumPy arrays, nodes in preorder.

        axis [N] int (3 = leaf), split [N] float32, left, right [N] int (children), first, count [N] int (of a leaf, in
        `triangles`), pairs [N] int (what a leaf holds as the builder counts), low, high [N, 3] float32 (the node's box),
        depth [N] int, triangles [R] int.
        """
        if self._open is not None and not self.fits(self._counters.read()):
            assert self.triangles is not None
            self.build(self.triangles)
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
