"""The kd-tree that is built on the GPU every frame.   [Zhou, Hou, Wang, Guo 2008; paper B section 4.3.2]

Large nodes are split level by level, empty space first, then at that of LARGE_PLANES planes across each axis which costs
least by the surface area heuristic; small ones at the best of all faces of their triangles' boxes, with masks instead of
lists; then the nodes are written in preorder. What Zhou 2008 leaves open is decided so: C_ts is a parameter; a candidate
plane must lie strictly inside its node; a triangle in the plane goes left, and boxes are padded so that it goes both ways;
large nodes that cannot be split well (their children would hold more than `growth_limit` times their triangles) become
leaves; no tree is deeper than the tracer's stack.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ..errors import InputError
from ..gpu import shader
from ..gpu.buffers import TextureBuffer
from ..gpu.layout import shared
from .triangles import Triangles

CONSTANTS, _ = shared("trace/shared.glsl")
LONGEST_LEAF = 60_000  # a loop over more triangles could end silently on a software rasteriser
# Texture units and storage bindings of the passes kdtree_*.comp; two `active` lists take turns.
UNITS = {
    "corners": 0, "refs": 1, "nodes": 2, "active": 3, "lanes": 4, "masks": 5, "roots": 6, "places": 7, "bounds": 8,
    "leaf_pairs": 9, "attributes": 10, "pairs": 11,
}  # fmt: skip
BINDINGS = {
    "refs": 1, "nodes": 3, "lanes": 4, "active": 6, "roots": 7, "masks": 8, "sizes": 9, "places": 10,
    "tree_nodes": 11, "leaf_pairs": 12, "leaf_corners": 13,
}  # fmt: skip
COUNTERS_BINDING = 5
# Invocations that share a large node: many while the nodes are few, so that every core has work.
LANE_BYTES = 16 * CONSTANTS["LANE_TEXELS"]
LANES_OF_ALL, FEWEST_LANES, MOST_LANES = 1024, 16, 128
LANE_REFS = 0xFFFF  # the most references that a lane can count (glsl/trace/split.glsl side_counts)
# Texels of each buffer: per node ("n"), per reference ("r"), per reference in a leaf ("l"); their format.
SIZES = {
    "nodes": ("n", 4, "rgba32ui"), "active_a": ("n", 1, "r32ui"), "active_b": ("n", 1, "r32ui"),
    "sizes": ("n", 1, "rg32ui"), "places": ("n", 1, "rg32ui"), "tree_nodes": ("n", 1, "rg32ui"),
    "refs": ("r", 6, "rgba32ui"), "masks": ("r", 6, "rgba32ui"), "roots": ("r", 1, "rgba32ui"),
    "leaf_pairs": ("l", 1, "r32ui"), "leaf_corners": ("l", 4, "rgba32ui"),
}  # fmt: skip


@dataclass(frozen=True)
class KdTreeParameters:
    """How the tree is built.

    C_ts: cost of a step in triangle tests. small_size: the most triangles of a small node (at most 64). empty_share:
    C_e, the share of a node's extent above which empty space is cut off. growth_limit: the most by which a split may
    multiply the triangles of a large node. pairs: two triangles that share an edge are one to the builder and the tracer.
    """

    C_ts: float = 2.0
    small_size: int = 64
    empty_share: float = 0.15
    growth_limit: float = 1.6
    pairs: bool = True

    def __post_init__(self):
        if not 1 <= self.small_size <= CONSTANTS["MASK_BITS"]:
            raise InputError(f"kd-tree: small_size = {self.small_size}, expected 1 to {CONSTANTS['MASK_BITS']}")
        for name, low, high in (("C_ts", 0, 1e6), ("empty_share", 0.01, 1), ("growth_limit", 1, 2)):
            if not low <= getattr(self, name) <= high:
                raise InputError(f"kd-tree: {name} = {getattr(self, name)}, expected {low:g} to {high:g}")


class KdTree:
    """A kd-tree of `Triangles` on the GPU.

    After `build`: node_count, leaf_ref_count (of pairs), low and high (the root's box), timings (ms per stage), and growths, how
    often a buffer was too small so far.
    """

    name = "kdtree"
    source = "inputs/accel/kdtree.glsl"
    settles = True

    def __init__(self, ctx, parameters: KdTreeParameters | None = None, room: float = 1.0):
        """`room` scales the first guess of the buffers' sizes."""
        self.ctx = ctx
        self.parameters = parameters or KdTreeParameters()
        self._room = room
        self._programs: dict[str, object] = {}
        self._buffers: dict[str, TextureBuffer] = {
            name: TextureBuffer(ctx, 16, texel) for name, (_, _, texel) in SIZES.items()
        }
        self._buffers["bounds"] = TextureBuffer(ctx, 4 * 64, "r32ui")
        self._buffers["lanes"] = TextureBuffer(ctx, LANE_BYTES * MOST_LANES, "rgba32ui")
        self._counters = ctx.buffer(reserve=4 * CONSTANTS["COUNTERS"], dynamic=True)
        self._capacity = {"n": 0, "r": 0, "l": 0}
        self._laps: list[tuple[str, float]] = []
        self.timings: dict[str, float] = {}
        self.growths = 0
        self.node_count = self.leaf_ref_count = self.root_count = self.large_levels = self.small_levels = 0
        self.low, self.high = np.zeros(3, np.float32), np.zeros(3, np.float32)

    # -- building ------------------------------------------------------------------------------------------------

    def build(self, triangles: Triangles) -> None:
        """Build the tree of the triangles as they are now; buffers that turn out too small grow, and it starts again.

        Raises InputError when more than 60,000 triangles lie so upon each other that no plane parts them.
        """
        for _ in self.build_steps(triangles):
            pass

    def build_steps(self, triangles: Triangles) -> Iterator[None]:
        """As `build`, stage by stage, for a caller with other things to do in between."""
        if triangles.count == 0:
            self._empty()
            return
        count, _ = triangles.pairs(self.parameters.pairs)
        self._grow("n", int(self._room * (3 * count + 256)), more=False)
        self._grow("r", max(int(self._room * (2.5 * count + 256)), count), more=False)
        while not (yield from self._attempt(triangles)):
            self.growths += 1

    def _attempt(self, triangles: Triangles) -> Iterator[None]:
        """One build; returns False when a buffer was too small, which is larger then."""
        p, capacity = self.parameters, self._capacity
        self._laps = [("", time.perf_counter())]
        counters = np.zeros(CONSTANTS["COUNTERS"], np.uint32)
        counters[CONSTANTS["NODE_COUNT"]] = 1
        self._counters.write(counters.tobytes())
        self._bind_stages(triangles)
        self._write("active", "active_a")
        count, _ = triangles.pairs(p.pairs)
        self._run("init", -(-count // 64), pair_count=count, padding=triangles.padding)
        self._lap("init")

        generations = [0, 1]
        levels = self._large(triangles.padding, generations)
        if levels is None:
            return False
        self.large_levels = levels
        counters = self._read_counters()
        self.root_count = int(counters[CONSTANTS["ROOT_COUNT"]])
        longest = int(counters[CONSTANTS["LONGEST_LEAF_COUNT"]])
        if longest > LONGEST_LEAF:
            raise InputError(
                f"kd-tree: {longest} triangles lie upon each other, expected at most {LONGEST_LEAF}; are they copies?"
            )
        self._lap("large")
        yield
        self._resume(triangles)
        self._read("roots")
        self._write("active", "active_a")
        small = {"small_base": 2 * capacity["r"]}
        self._run("masks", self.root_count, root_count=self.root_count, **small)
        roots = self._next_active()
        self._lap("masks")

        self._read("masks")
        levels = self._small(roots, generations, node_capacity=capacity["n"], C_ts=p.C_ts, **small)
        if levels is None:
            return False
        self.small_levels = levels
        self._lap("small")
        yield
        self._resume(triangles)
        generations = sorted(set(generations))
        self.node_count = generations[-1]
        self._buffers["bounds"].write(np.array(generations, np.uint32))
        self._read("bounds")
        self._run("order", 1, generation_count=len(generations) - 1)
        self.leaf_ref_count = int(self._read_counters()[CONSTANTS["LEAF_REF_COUNT"]])
        self._lap("order")

        self._grow("l", self.leaf_ref_count, more=False)
        self._write("leaf_pairs")
        self._write("leaf_corners")
        self._read("places")
        self._run("emit", -(-self.node_count // 64), node_count=self.node_count)
        self._read("leaf_pairs")
        self._run("leaves", -(-self.leaf_ref_count // 64), leaf_ref_count=self.leaf_ref_count)
        root = np.frombuffer(self._buffers["nodes"].buffer.read(32), np.float32)
        self.low, self.high = root[:3].copy(), root[4:7].copy()
        self._lap("emit")
        return True

    def _bind_stages(self, triangles: Triangles) -> None:
        """Bind what all stages share."""
        for name in ("refs", "nodes", "roots", "masks", "sizes", "places", "tree_nodes", "leaf_pairs"):
            self._write(name)
        self._read("refs")
        self._read("nodes")
        self._counters.bind_to_storage_buffer(COUNTERS_BINDING)
        triangles.corners.bind(UNITS["corners"])
        triangles.attributes.bind(UNITS["attributes"])
        triangles.pairs(self.parameters.pairs)[1].bind(UNITS["pairs"])

    def _resume(self, triangles: Triangles) -> None:
        """Bind again what others may have unbound since the last stage; what they took is no part of the build's time."""
        self._bind_stages(triangles)
        self._read("roots")
        self._read("masks")
        self._laps.append(("", time.perf_counter()))

    def _large(self, padding: float, generations: list[int]) -> int | None:
        """Split the large nodes level by level; the number of levels, None when a buffer was too small."""
        p, refs = self.parameters, self._capacity["r"]
        fewest = max(FEWEST_LANES, -(-refs // LANE_REFS))
        active, level = 1, 0
        while active:
            lanes = max(min(LANES_OF_ALL >> (active - 1).bit_length(), MOST_LANES), fewest)
            self._buffers["lanes"].reserve(LANE_BYTES * lanes * active)
            self._write("lanes")
            self._read("lanes")
            self._turn(level)
            every = {"active_count": active, "lanes": lanes}
            self._run("measure", -(-active * lanes // 64), **every)
            if level == 0:
                # Where the middle is, is known only now.
                self._run("root", 1, lanes=lanes)
                self._run("measure", -(-active * lanes // 64), **every)
            self._run(
                "divide", -(-active // 64), level=level, small_size=p.small_size, empty_share=p.empty_share,
                growth_limit=p.growth_limit, node_capacity=self._capacity["n"], ref_capacity=refs,
                next_base=refs * ((level + 1) % 2), small_base=2 * refs, **every,
            )  # fmt: skip
            self._run("scatter", -(-active * lanes // 64), padding=padding, **every)
            if not self._made(generations):
                return None
            active, level = self._next_active(), level + 1
        return level

    def _small(self, active: int, generations: list[int], **uniforms) -> int | None:
        """Split the small nodes level by level; the number of levels, None when a buffer was too small."""
        level = 0
        while active:
            self._turn(level)
            self._run("small", -(-active // 64), active_count=active, level=level, **uniforms)
            if not self._made(generations):
                return None
            active, level = self._next_active(), level + 1
        return level

    def _turn(self, level: int) -> None:
        """Let the two lists of active nodes change places."""
        self._read("active", ("active_a", "active_b")[level % 2])
        self._write("active", ("active_b", "active_a")[level % 2])

    def _made(self, generations: list[int]) -> bool:
        """Note the nodes that a level made; False when a buffer was too small, which is larger then."""
        counters = self._read_counters()
        needs = int(counters[CONSTANTS["NEED_NODES"]]), int(counters[CONSTANTS["NEED_REFS"]])
        if any(needs):
            self._grow("n", needs[0], more=True)
            self._grow("r", needs[1], more=True)
            return False
        generations.append(int(counters[CONSTANTS["NODE_COUNT"]]))
        return True

    def _next_active(self) -> int:
        """The number of nodes of the next level; its counters start from 0 again."""
        at = CONSTANTS["ACTIVE_COUNT"]
        assert CONSTANTS["NEXT_REF_COUNT"] == at + 1
        active = int(np.frombuffer(self._counters.read(4, offset=4 * at), np.uint32)[0])
        self._counters.write(bytes(8), offset=4 * at)
        return active

    def _read_counters(self) -> np.ndarray:
        return np.frombuffer(self._counters.read(), np.uint32)

    def _empty(self) -> None:
        """The tree of no triangles: one leaf without any."""
        self._grow("n", 1, more=False)
        self._grow("l", 1, more=False)
        self._buffers["tree_nodes"].write(np.array([0, 3], np.uint32))
        self.node_count, self.leaf_ref_count, self.root_count = 1, 0, 0
        self.low[:], self.high[:] = 0, 0
        self.timings = {}

    # -- the machinery -------------------------------------------------------------------------------------------

    def _grow(self, unit: str, need: int, more: bool) -> None:
        """Make room for `need` nodes, references or leaf references; with `more`, for half as many again."""
        if need <= self._capacity[unit]:
            return
        need = max(need * 3 // 2 if more else need, 64)
        self._capacity[unit] = need
        for name, (per, texels, _) in SIZES.items():
            if per == unit:
                buffer = self._buffers[name]
                buffer.reserve(need * texels * buffer.texel_bytes)

    def _read(self, name: str, buffer: str | None = None) -> None:
        self._buffers[buffer or name].bind(UNITS[name])

    def _write(self, name: str, buffer: str | None = None) -> None:
        self._buffers[buffer or name].buffer.bind_to_storage_buffer(BINDINGS[name])

    def _run(self, stage: str, groups: int, **uniforms) -> None:
        """Dispatch one pass and make what it wrote visible to all that follows."""
        if groups == 0:
            return
        if stage not in self._programs:
            self._programs[stage] = shader.compute(self.ctx, f"passes/accel/kdtree_{stage}.comp")
        program = self._programs[stage]
        shader.set_uniforms(program, **uniforms)
        # One dimension holds 65,535 groups; the passes of one group a root count on in the second.
        columns = min(groups, 32_768) if stage == "masks" else groups
        program.run(columns, -(-groups // columns))
        self.ctx.memory_barrier()

    def _lap(self, stage: str) -> None:
        now = time.perf_counter()
        self._laps.append((stage, now))
        pairs = zip(self._laps[:-1], self._laps[1:], strict=True)
        self.timings = {name: 1000 * (end - start) for (_, start), (name, end) in pairs if name}

    # -- tracing and looking -------------------------------------------------------------------------------------

    def bind(self, program) -> None:
        """Bind what inputs/accel/kdtree.glsl reads."""
        self._buffers["tree_nodes"].bind(8)
        self._buffers["leaf_corners"].bind(9)
        shader.set_uniforms(program, scene_low=tuple(map(float, self.low)), scene_high=tuple(map(float, self.high)))

    def chunks(self):
        """The uniforms of each dispatch that one query takes."""
        yield {}

    def arrays(self) -> dict[str, np.ndarray]:
        """The tree as NumPy arrays, nodes in preorder.

        axis [N] int (3 = leaf), split [N] float32, left, right [N] int (children), first, count [N] int (of a leaf, in
        `triangles`), pairs [N] int (what a leaf holds as the builder counts), low, high [N, 3] float32 (the node's box),
        depth [N] int, triangles [R] int.
        """
        nodes = np.frombuffer(self._buffers["tree_nodes"].buffer.read(8 * self.node_count), np.uint32).reshape(-1, 2)
        refs = self._buffers["leaf_pairs"].buffer.read(4 * self.leaf_ref_count) if self.leaf_ref_count else b""
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
        for thing in (*self._buffers.values(), *self._programs.values(), self._counters):
            thing.release()
