"""The rays of one tile of a picture, in queues: cast, parted, shaded and shadowed, generation by generation.

Light through cloth goes straight on, so one traversal of a kd-tree finds all layers along a way at once, and only the
heads of ways are cast: camera rays and mirrored ones. The queues keep the radiance of each ray; at the end children are
added to their parents, so that no sum depends on the order in which the GPU works.   [Mat section 4.2]
"""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, NamedTuple

import moderngl
import numpy as np

from ..accel.queries import cast_counted
from ..accel.structure import Structure
from ..gpu.buffers import Buffer, TextureBuffer
from ..gpu.layout import shared
from ..gpu.programs import Compute, programs
from .fabrics import fabric_defines
from .shot import DEEPEST, Shot, TraceStatistics
from .threads import INCLUDE, LANES

CONSTANTS: Mapping[str, Any] = shared("trace/shared.glsl")[0]
COUNTS: Mapping[str, Any] = shared("inputs/tracing/counts.glsl")[0]
SIZE = 4 * COUNTS["COUNTS"]  # bytes
KINDS: int = shared("inputs/tracing/parts.glsl")[0]["LIGHT_PARTS"]
BLOCK: tuple[int, int] = (CONSTANTS["BLOCK_WIDTH"], CONSTANTS["BLOCK_HEIGHT"])


class Tile(NamedTuple):
    """A part of a picture: its first pixel, rows counted from below, and how many blocks of pixels across and up."""

    first: tuple[int, int]
    blocks: tuple[int, int]

    @property
    def rays(self) -> int:
        """Camera rays of one sample, including pixels beyond the picture's edge."""
        return BLOCK[0] * BLOCK[1] * self.blocks[0] * self.blocks[1]

    def pixels(self, size: tuple[int, int]) -> int:
        """How many pixels of a picture lie in it."""
        across, up = (min(b * n, s - f) for b, n, s, f in zip(BLOCK, self.blocks, size, self.first, strict=True))
        return across * up


@dataclass(frozen=True)
class Picture:
    """The values that all tiles of a picture share.

    structure : built. inputs : of the passes, from scene, camera and light. buffer : where samples are added, a vec4
    a pixel. statistics : to add to. parts : where the kinds of light are added, KINDS of a vec4 a pixel; None: nowhere.
    """

    shot: Shot
    structure: Structure
    inputs: Mapping[str, Any]
    buffer: Buffer
    statistics: TraceStatistics
    parts: Buffer | None = None

    @property
    def holes(self) -> dict[str, Any]:
        """The defines of passes that know the cloth: where a weave has its holes, and that there are several fabrics."""
        return ({"HOLES": 1} if "hole_map" in self.inputs else {}) | fabric_defines(self.inputs)

    @property
    def threads(self) -> dict[str, Any]:
        """The defines of passes that know where it has its threads, too."""
        if "hole_map" not in self.inputs:
            return self.holes
        woven = {"WEAVE": 1, "GROUPS": self.inputs.get("tangent_groups"), "LANE_COUNT": LANES}
        return {**self.holes, **woven}

    @property
    def stride(self) -> int:
        """How many layers a head has room for: all of a way at once, where the structure finds hits in order and no ray
        turns aside in the cloth."""
        settings = self.shot.settings
        return settings.depth if self.structure.ordered_hits and not settings.spread else 1


class Generation:
    """The queues of one generation of rays, some of which lie at the front, the others at the very end."""

    def __init__(self, ctx: moderngl.Context):
        self.weights = TextureBuffer(ctx, 64)
        self.radiance = TextureBuffer(ctx, 64)
        self.children = TextureBuffer(ctx, 64, "rg32ui")
        self.capacity = 0

    def reserve(self, capacity: int) -> None:
        """Make room for so many rays, or as many as there is room for."""
        self.capacity = capacity = max(capacity, self.capacity)
        for buffer in (self.weights, self.radiance, self.children):
            buffer.reserve(capacity * buffer.texel_bytes)

    def release(self) -> None:
        """Free the GPU's memory."""
        for buffer in (self.weights, self.radiance, self.children):
            buffer.release()


class Rays:
    """The queues of rays on one context; each tile begins anew with them."""

    def __init__(self, ctx: moderngl.Context):
        self.ctx = ctx
        self._generations = [Generation(ctx) for _ in range(DEEPEST + 1)]
        self._heads = TextureBuffer(ctx, 64)
        self._head_capacity = 0
        self._layers = TextureBuffer(ctx, 64, "rgba32ui")  # that the heads meet
        self._order = TextureBuffer(ctx, 64, "r32ui")  # of the rays of a generation, to shade
        self._shadows = TextureBuffer(ctx, 64)
        self._counts = Buffer(ctx, SIZE)
        self._unread = Buffer(ctx, SIZE)  # the counts of tiles that nobody has seen to have had room,
        self._stages: list[list[list[float]]] = []  # and the milliseconds of their generations
        self._parts = Buffer(ctx, 64)  # of the camera's rays, where a picture wants its kinds of light

    def trace(self, picture: Picture, tile: Tile, sample: int, later: bool = False) -> None:
        """Add one sample of each pixel of a tile to the picture.

        later : the CPU does not wait to see whether there was room: `unread` is to be read with what else is read of the
            picture, and given to `fits`
        """
        shot = picture.shot
        where = {"size": shot.size, "tile_first": tile.first, "tile_blocks": tile.blocks}
        self._make_room(tile.rays, shot.settings.depth)
        if later:
            self._stages.append(self._attempt(picture, tile.rays, where, sample))
            self._unread.extend(SIZE * len(self._stages))
            self.ctx.copy_buffer(
                self._unread.buffer, self._counts.buffer, SIZE, write_offset=SIZE * (len(self._stages) - 1)
            )
        else:
            fits = False
            while not fits:
                stages = self._attempt(picture, tile.rays, where, sample)
                fits = self._look(self._counts.read(SIZE), picture.statistics, stages)
        for level in reversed(range(shot.settings.depth - 1)):
            parent, child = self._generations[level : level + 2]
            defines, kinds = self._parted(picture, level == 0)
            programs(self.ctx).compute("passes/tracing/gather.comp", defines).run_indirect(
                self._counts, kinds, skip=4 * (COUNTS["LOG"] + COUNTS["LOG_COUNTS"] * level + 4), level=level,
                capacity=parent.capacity, next_radiance=child.radiance, children=parent.children,
                Radiances=parent.radiance, Counts=self._counts,
            )  # fmt: skip
        first = self._generations[0].radiance
        defines, kinds = self._parted(picture, True)
        if picture.parts is not None:
            kinds["PictureParts"] = picture.parts
        programs(self.ctx).compute("passes/tracing/picture.comp", defines).run(
            tile.rays, where, kinds, share=1.0 / len(shot.samples), radiances=first, Picture=picture.buffer
        )

    def begin(self) -> None:
        """Forget what is unread."""
        self._stages = []

    @property
    def unread(self) -> tuple[Buffer, int]:
        """The counts of the tiles since `begin` that were traced with `later`, and how many bytes they are."""
        return self._unread, SIZE * len(self._stages)

    def fits(self, data: bytes, statistics: TraceStatistics) -> bool:
        """Whether the tiles whose `unread` counts these are had room; else there is more now, and they are to be traced anew."""
        tiles = [data[at : at + SIZE] for at in range(0, len(data), SIZE)]
        # Each is looked at: the one that needs most makes most room.
        return all([self._look(one, statistics, stages) for one, stages in zip(tiles, self._stages, strict=True)])

    def _parted(self, picture: Picture, first: bool) -> tuple[dict[str, int], dict[str, Any]]:
        """Defines and inputs of the passes that keep the kinds of light of the first generation apart, where that is asked."""
        return ({"PARTED": 1}, {"Parts": self._parts}) if first and picture.parts is not None else ({}, {})

    def _make_room(self, rays: int, depth: int) -> None:
        """Places for a first try: of the last picture, or as if each generation had as many rays as the first."""
        for level in range(depth):
            self._generations[level].reserve(rays)
        self._generations[depth].reserve(1)
        self._head_capacity = max(self._head_capacity, rays + rays // 2)

    def _attempt(self, picture: Picture, rays: int, where: Mapping[str, Any], sample: int) -> list[list[float]]:
        """Trace all generations of so many camera rays; returns the milliseconds of their stages.

        The GPU counts the rays of each generation and dispatches by them; the CPU does not wait.
        """
        shot, first, settings = picture.shot, self._generations[0], picture.shot.settings
        self._heads.reserve(32 * self._head_capacity)
        self._layers.reserve(16 * picture.stride * self._head_capacity)
        self._order.reserve(4 * max(generation.capacity for generation in self._generations))
        self._shadows.reserve(32 * max(generation.capacity for generation in self._generations))
        if picture.parts is not None:
            self._parts.reserve(16 * KINDS * first.capacity)
        self._begin_counts(rays)
        programs(self.ctx).compute("passes/tracing/camera.comp").run(
            rays, where, picture.inputs, jitter=shot.samples[sample], stride=picture.stride, Heads=self._heads,
            Weights=first.weights,
        )  # fmt: skip
        return [self._trace_generation(picture, level, sample) for level in range(settings.depth)]

    def _look(self, data: bytes, statistics: TraceStatistics, stages: list[list[float]]) -> bool:
        """Whether there was room for the rays of a tile, by its counts; else there is more now."""
        counts = np.frombuffer(data, np.uint32)
        log = counts[COUNTS["LOG"] :].reshape(-1, COUNTS["LOG_COUNTS"])[:, :4].tolist()
        need_rays, need_heads = int(counts[COUNTS["NEED_RAYS"]]), int(counts[COUNTS["NEED_HEADS"]])
        if need_rays or need_heads:
            # Those behind it are not known yet.
            level = sum(row[0] > 0 for row in log)
            for generation in self._generations[level : len(stages)]:
                generation.reserve(need_rays + need_rays // 4)
            self._head_capacity = max(self._head_capacity, need_heads + need_heads // 4)
            return False
        for level, (count, _, heads, shadows) in enumerate(log):
            if count:
                statistics.add(level, count, heads, shadows, stages[level])
        return True

    def _begin_counts(self, rays: int) -> None:
        """Write the counters of a generation of camera rays alone."""
        counts = np.zeros(COUNTS["COUNTS"], np.uint32)
        for name in ("RAYS", "FRONT", "HEADS", "CAST"):
            counts[COUNTS[name]] = rays
        log = COUNTS["LOG"]
        counts[log : log + 3] = rays
        most, group = programs(self.ctx).most_groups, COUNTS["GROUP"]
        rows = -(-rays // (group * most))
        counts[COUNTS["COLUMN_RAYS"]] = rows * group
        for name, items in (
            ("RAY_GROUPS", -(-rays // CONSTANTS["PART_SHARE"])), ("HEAD_GROUPS", rays), ("CLOTH_GROUPS", 0),
            ("OTHER_GROUPS", 0), ("SHADOW_GROUPS", 0),
        ):  # fmt: skip
            groups = -(-items // group)
            down = -(-groups // most) if items else rows
            counts[COUNTS[name] :][:3] = -(-groups // down), down, 1
        groups = -(-rays // group)
        down = -(-groups // most)
        counts[log + 4 : log + 7] = -(-groups // down), down, 1
        self._counts.write(counts)

    def _trace_generation(self, picture: Picture, level: int, sample: int) -> list[float]:
        """Cast, shade and shadow one generation, and make the next; the milliseconds of each."""
        clock = [time.perf_counter()]
        self._cast(picture, level)
        clock.append(time.perf_counter())
        self._shade(picture, level, sample)
        clock.append(time.perf_counter())
        self._shadow(picture, level)
        clock.append(time.perf_counter())
        return [1000 * (b - a) for a, b in pairwise(clock)]

    def _cast(self, picture: Picture, level: int) -> None:
        """Find the new heads' hits: layers, or with a stride of 1 the nearest one."""
        structure, stride = picture.structure, picture.stride
        if stride == 1:
            cast_counted(structure, self._heads, self._layers, self._counts, 4 * COUNTS["HEAD_GROUPS"])
        else:
            _through(self.ctx, "passes/tracing/layers.comp", structure).run_indirect(
                self._counts, structure.inputs(), skip=4 * COUNTS["HEAD_GROUPS"], heads=self._heads, Layers=self._layers,
                Counts=self._counts, stride=stride, most_layers=picture.shot.settings.depth - level,
            )  # fmt: skip

    def _shade(self, picture: Picture, level: int, sample: int) -> None:
        """Shade the hits of a generation and make the rays of the next."""
        now, then = self._generations[level], self._generations[level + 1]
        settings = picture.shot.settings
        parted, kinds = self._parted(picture, level == 0)
        programs(self.ctx).compute("passes/tracing/sort.comp").run_indirect(
            self._counts, picture.inputs, skip=4 * COUNTS["RAY_GROUPS"], layers=self._layers, weights=now.weights,
            Order=self._order, Counts=self._counts, capacity=now.capacity,
        )  # fmt: skip
        for cloth, groups in ((1, COUNTS["CLOTH_GROUPS"]), (0, COUNTS["OTHER_GROUPS"])):
            shade = programs(self.ctx).compute(
                "passes/tracing/shade.comp",
                {
                    "CLOTH": cloth,
                    "SPREAD": int(settings.spread),
                    "GI": int(picture.shot.indirect is not None),
                    **(picture.threads if cloth else {}),
                    **parted,
                },
                {
                    "indirect.glsl": picture.shot.indirect_source,
                    **(INCLUDE if cloth and "WEAVE" in picture.threads else {}),
                },
            )
            shade.run_indirect(
                self._counts, picture.inputs, kinds, skip=4 * groups, layers=self._layers, order=self._order, heads=self._heads,
                weights=now.weights, Heads=self._heads, Weights=then.weights, Radiances=now.radiance,
                Children=now.children, Shadows=self._shadows, Counts=self._counts, next_last=then.capacity - 1, level=level,
                last_level=settings.depth - 1, generation_seed=sample * DEEPEST + level, stride=picture.stride,
                layered=picture.stride > 1, head_capacity=self._head_capacity,
            )  # fmt: skip
        programs(self.ctx).compute("passes/tracing/generation.comp").run(
            1, Counts=self._counts, level=level, next_capacity=then.capacity, head_capacity=self._head_capacity,
            most_groups=programs(self.ctx).most_groups,
        )  # fmt: skip

    def _shadow(self, picture: Picture, level: int) -> None:
        """Add the lamp's light to the rays of a generation that wait for it."""
        structure, now = picture.structure, self._generations[level]
        parted, kinds = self._parted(picture, level == 0)
        program = _through(self.ctx, "passes/tracing/shadow.comp", structure, picture.holes | parted)
        chunks = list(structure.chunks())
        for k, chunk in enumerate(chunks):
            program.run_indirect(
                self._counts, structure.inputs(), picture.inputs, chunk, kinds, skip=4 * COUNTS["SHADOW_GROUPS"],
                shadows=self._shadows, Shadows=self._shadows, Radiances=now.radiance, Counts=self._counts,
                last_chunk=k == len(chunks) - 1,
            )  # fmt: skip

    def release(self) -> None:
        """Free the GPU's memory."""
        for buffer in (self._heads, self._layers, self._order, self._shadows, self._counts, self._unread, self._parts):
            buffer.release()
        for generation in self._generations:
            generation.release()


def _through(
    ctx: moderngl.Context, path: str, structure: Structure, defines: Mapping[str, Any] | None = None
) -> Compute:
    """The program of a pass that sends rays through a structure."""
    virtual = {"accel.glsl": structure.source, "count.glsl": "inputs/accel/count_none.glsl"}
    return programs(ctx).compute(path, dict(defines or {}), virtual)
