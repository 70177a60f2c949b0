"""Queries of many rays through any acceleration structure."""

from __future__ import annotations

from typing import Literal, NamedTuple

import moderngl
import numpy as np

from ..gpu.buffers import Buffer, TextureBuffer
from ..gpu.programs import Compute, programs
from .structure import Traced

NO_TRIANGLE = 0xFFFFFFFF
Visitor = Literal["closest", "any"]
VISITORS: dict[Visitor, str] = {"closest": "inputs/accel/visit_closest.glsl", "any": "inputs/accel/visit_any.glsl"}


class Hits(NamedTuple):
    """The hits of rays: t [N] float32 (inf: nothing), triangle [N] int (-1: nothing), weights [N, 2] float32
    (barycentric coordinates of the second and third corner); work [N, 2] int (steps, triangle tests) if asked for."""

    t: np.ndarray
    triangle: np.ndarray
    weights: np.ndarray
    work: np.ndarray | None


class RayQueries:
    """Casts arrays of rays through a structure."""

    def __init__(self, ctx: moderngl.Context):
        self.ctx = ctx
        self._rays = TextureBuffer(ctx, 1 << 16)
        self._hits = Buffer(ctx, 1 << 16)
        self._work = Buffer(ctx, 1 << 16)

    def closest_hit(
        self, structure: Traced, origins, directions, t_min=0.0, t_max=np.inf, counted: bool = False
    ) -> Hits:
        """The nearest hit of each ray with t_min < t < t_max.

        Parameters
        ----------
        structure : built
        origins, directions : [N, 3]; t is in units of the direction's length
        t_min, t_max : [N] or one for all
        counted : also count the steps and the triangle tests of each ray
        """
        return self._cast(structure, "closest", origins, directions, t_min, t_max, counted)

    def any_hit(self, structure: Traced, origins, directions, t_min=0.0, t_max=np.inf) -> np.ndarray:
        """Whether each ray hits anything with t_min < t < t_max: [N] bool. Parameters as for `closest_hit`."""
        return self._cast(structure, "any", origins, directions, t_min, t_max, False).triangle >= 0

    def _cast(self, structure: Traced, visit: Visitor, origins, directions, t_min, t_max, counted) -> Hits:
        count = self.upload(origins, directions, t_min, t_max)
        self.run(structure, visit, count, counted)
        hits = np.frombuffer(self._hits.read(16 * count), np.uint32).reshape(-1, 4)
        missed = hits[:, 1] == NO_TRIANGLE
        return Hits(
            np.where(missed, np.float32(np.inf), np.ascontiguousarray(hits[:, 0]).view(np.float32)),
            np.where(missed, -1, hits[:, 1].astype(np.int64)),
            np.ascontiguousarray(hits[:, 2:]).view(np.float32),
            np.frombuffer(self._work.read(8 * count), np.uint32).reshape(-1, 2).astype(int) if counted else None,
        )

    def upload(self, origins, directions, t_min=0.0, t_max=np.inf) -> int:
        """Upload rays for `run`; returns how many."""
        origins = np.asarray(origins, np.float32).reshape(-1, 3)
        count = len(origins)
        rays = np.empty((count, 2, 4), np.float32)
        rays[:, 0, :3], rays[:, 1, :3] = origins, np.asarray(directions, np.float32).reshape(-1, 3)
        rays[:, 0, 3], rays[:, 1, 3] = t_min, np.minimum(t_max, np.float32(3e38))
        self._rays.write(rays)
        self._hits.reserve(16 * count)
        self._work.reserve(8 * count)
        return count

    def run(self, structure: Traced, visit: Visitor, count: int, counted: bool = False) -> None:
        """Cast the uploaded rays; the hits stay on the GPU."""
        cast(structure, visit, self._rays, self._hits, count, work=self._work if counted else None)

    def release(self) -> None:
        """Free the GPU's memory."""
        for thing in (self._rays, self._hits, self._work):
            thing.release()


def cast(
    structure: Traced, visit: Visitor, rays: TextureBuffer, hits: Buffer, count: int, work: Buffer | None = None
) -> None:
    """Cast the first `count` rays, as passes/accel/rays.comp lays out rays and hits.

    work : where the steps and the triangle tests of each ray are noted, two uints a ray
    """
    program = _program(rays.ctx, structure, visit, "inputs/accel/range_given.glsl", work is not None)
    where = {"ray_count": count, "first_ray": 0, "resume": 0, "Work": work}
    for chunk in structure.chunks():
        program.run(count, structure.inputs(), where | chunk, rays=rays, Hits=hits)


def cast_counted(structure: Traced, rays: TextureBuffer, hits: Buffer, counts: Buffer, skip: int) -> None:
    """Find the nearest hits of the rays that inputs/tracing/range_heads.glsl names by `counts`, by as many work groups as
    stand there behind `skip` bytes."""
    program = _program(rays.ctx, structure, "closest", "inputs/tracing/range_heads.glsl", False)
    for chunk in structure.chunks():
        program.run_indirect(
            counts, structure.inputs(), {"resume": 0} | chunk, skip=skip, rays=rays, Hits=hits, Counts=counts
        )


def _program(ctx: moderngl.Context, structure: Traced, visit: Visitor, range_: str, counted: bool) -> Compute:
    virtual = {
        "accel.glsl": structure.source,
        "visit.glsl": VISITORS[visit],
        "range.glsl": range_,
        "count.glsl": "inputs/accel/count_steps.glsl" if counted else "inputs/accel/count_none.glsl",
    }
    return programs(ctx).compute("passes/accel/rays.comp", None, virtual)
