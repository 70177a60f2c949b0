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

from ..accel.queries import cast
from ..accel.structure import Structure
from ..gpu.buffers import Buffer, TextureBuffer
from ..gpu.layout import shared
from ..gpu.programs import Compute, programs
from .shot import DEEPEST, Shot, TraceStatistics

CONSTANTS: Mapping[str, Any] = shared("trace/shared.glsl")[0]
COUNTS: Mapping[str, Any] = shared("inputs/tracing/counts.glsl")[0]
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
    a pixel. statistics : to add to.
    """

    shot: Shot
    structure: Structure
    inputs: Mapping[str, Any]
    buffer: Buffer
    statistics: TraceStatistics

    @property
    def stride(self) -> int:
        """How many layers a head has room for: all of a way at once, where the structure finds hits in order and no ray
        turns aside in the cloth."""
        settings = self.shot.settings
        return settings.depth if self.structure.ordered_hits and not settings.spread else 1


class Generation:
    """The queues of one generation of rays: `front` of them lie at the front, `back` at the very end."""

    def __init__(self, ctx: moderngl.Context):
        self.weights = TextureBuffer(ctx, 64)
        self.radiance = TextureBuffer(ctx, 64)
        self.children = TextureBuffer(ctx, 64, "rg32ui")
        self.front = self.back = self.capacity = 0

    def reserve(self, capacity: int) -> None:
        """Make room for so many rays."""
        self.capacity = capacity
        for buffer in (self.weights, self.radiance, self.children):
            buffer.reserve(capacity * buffer.texel_bytes)

    @property
    def count(self) -> int:
        """How many rays it has."""
        return self.front + self.back

    @property
    def runs(self) -> dict[str, int]:
        """Where the rays lie, by the names of the passes."""
        return {"ray_count": self.count, "front_count": self.front, "back_first": self.capacity - self.back}

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
        self._head_count = self._cast_count = 0
        self._layers = TextureBuffer(ctx, 64, "rgba32ui")  # that the heads meet
        self._order = TextureBuffer(ctx, 64, "r32ui")  # of the rays of a generation, to shade
        self._shadows = TextureBuffer(ctx, 64)
        self._counts = Buffer(ctx, 4 * COUNTS["COUNTS"])

    def trace(self, picture: Picture, tile: Tile, sample: int) -> None:
        """Add one sample of each pixel of a tile to the picture."""
        shot = picture.shot
        where = {"size": shot.size, "tile_first": tile.first, "tile_blocks": tile.blocks}
        first = self._generations[0]
        first.reserve(tile.rays)
        first.front, first.back = tile.rays, 0
        self._heads.extend(32 * tile.rays)
        self._head_count, self._cast_count = tile.rays, 0
        programs(self.ctx).compute("passes/tracing/camera.comp").run(
            tile.rays, where, picture.inputs, jitter=shot.samples[sample], stride=picture.stride, Heads=self._heads,
            Weights=first.weights,
        )  # fmt: skip
        level = 0
        while level < shot.settings.depth and self._generations[level].count:
            self._trace_generation(picture, level, sample)
            level += 1
        gather = programs(self.ctx).compute("passes/tracing/gather.comp")
        for parent, child in reversed(list(pairwise(self._generations[:level]))):
            gather.run(
                parent.count, parent.runs, next_radiance=child.radiance, children=parent.children,
                Radiances=parent.radiance,
            )  # fmt: skip
        programs(self.ctx).compute("passes/tracing/picture.comp").run(
            tile.rays, where, share=1.0 / len(shot.samples), radiances=first.radiance, Picture=picture.buffer
        )

    def _trace_generation(self, picture: Picture, level: int, sample: int) -> None:
        """Cast, shade and shadow one generation, and make the next."""
        now = self._generations[level]
        clock = [time.perf_counter()]
        heads = self._cast(picture, level)
        clock.append(time.perf_counter())
        shadows = self._shade(picture, level, sample)
        clock.append(time.perf_counter())
        self._shadow(picture, now, shadows)
        clock.append(time.perf_counter())
        stages = [1000 * (b - a) for a, b in pairwise(clock)]
        picture.statistics.add(level, now.count, heads, shadows, stages)

    def _cast(self, picture: Picture, level: int) -> int:
        """Find the new heads' hits: layers, or with a stride of 1 the nearest one; how many heads there are."""
        structure, stride = picture.structure, picture.stride
        first, count = self._cast_count, self._head_count - self._cast_count
        self._cast_count = self._head_count
        if not count:
            return 0
        self._layers.extend(16 * stride * (first + count))
        if stride == 1:
            cast(structure, "closest", self._heads, self._layers, count, first)
        else:
            _through(self.ctx, "passes/tracing/layers.comp", structure).run(
                count, structure.inputs(), heads=self._heads, Layers=self._layers, first_head=first, head_count=count,
                stride=stride, most_layers=picture.shot.settings.depth - level,
            )  # fmt: skip
        return count

    def _shade(self, picture: Picture, level: int, sample: int) -> int:
        """Shade the hits of a generation and make the rays of the next; how many shadow rays wait then."""
        now, then = self._generations[level], self._generations[level + 1]
        settings = picture.shot.settings
        then.reserve(max(2 * now.count, 1) if level + 1 < settings.depth else 1)
        self._shadows.reserve(32 * now.count)
        self._heads.extend(32 * (self._head_count + 2 * now.count))
        self._order.reserve(4 * now.count)
        counts = np.zeros(COUNTS["COUNTS"], np.uint32)
        counts[COUNTS["HEADS"]] = self._head_count
        # Work groups along y, where a device may not take all of them along x.
        rows = -(-now.count // (COUNTS["GROUP"] * programs(self.ctx).most_groups))
        for groups in (COUNTS["CLOTH_GROUPS"], COUNTS["OTHER_GROUPS"]):
            counts[groups + 1 : groups + 3] = rows, 1
        self._counts.write(counts)
        programs(self.ctx).compute("passes/tracing/sort.comp").run(
            -(-now.count // CONSTANTS["PART_SHARE"]), now.runs, picture.inputs, layers=self._layers, weights=now.weights,
            Order=self._order, Counts=self._counts, column_rays=rows * COUNTS["GROUP"],
        )  # fmt: skip
        for cloth, groups in ((1, COUNTS["CLOTH_GROUPS"]), (0, COUNTS["OTHER_GROUPS"])):
            shade = programs(self.ctx).compute(
                "passes/tracing/shade.comp",
                {"CLOTH": cloth, "SPREAD": int(settings.spread), "GI": int(picture.shot.indirect is not None)},
                {"indirect.glsl": picture.shot.indirect_source},
            )
            shade.run_indirect(
                self._counts, picture.inputs, skip=4 * groups, layers=self._layers, order=self._order, heads=self._heads,
                weights=now.weights, Heads=self._heads, Weights=then.weights, Radiances=now.radiance,
                Children=now.children, Shadows=self._shadows, Counts=self._counts, next_last=then.capacity - 1, level=level,
                last_level=settings.depth - 1, generation_seed=sample * DEEPEST + level, stride=picture.stride,
                layered=picture.stride > 1,
            )  # fmt: skip
        read = np.frombuffer(self._counts.read(4 * COUNTS["READ_COUNTS"]), np.uint32)
        then.front, then.back = int(read[COUNTS["ONWARD"]]), int(read[COUNTS["MIRRORED"]])
        self._head_count = int(read[COUNTS["HEADS"]])
        return int(read[COUNTS["WAITING"]])

    def _shadow(self, picture: Picture, now: Generation, count: int) -> None:
        """Add the lamp's light to the rays that wait for it."""
        structure = picture.structure
        program = _through(self.ctx, "passes/tracing/shadow.comp", structure)
        chunks = list(structure.chunks())
        for k, chunk in enumerate(chunks):
            program.run(
                count, structure.inputs(), picture.inputs, chunk, shadows=self._shadows, Shadows=self._shadows,
                Radiances=now.radiance, shadow_count=count, last_chunk=k == len(chunks) - 1,
            )  # fmt: skip

    def release(self) -> None:
        """Free the GPU's memory."""
        for buffer in (self._heads, self._layers, self._order, self._shadows, self._counts):
            buffer.release()
        for generation in self._generations:
            generation.release()


def _through(ctx: moderngl.Context, path: str, structure: Structure) -> Compute:
    """The program of a pass that sends rays through a structure."""
    virtual = {"accel.glsl": structure.source, "count.glsl": "inputs/accel/count_none.glsl"}
    return programs(ctx).compute(path, None, virtual)
