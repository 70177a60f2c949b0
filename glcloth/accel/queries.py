"""Acceleration structures behind one interface, and queries of many rays through any of them.

A structure has `build(triangles)`, `bind(program)`, `chunks()` (the uniforms of each dispatch of a query), `source` (the
pass file with `traverse`), `settles` (whether that finds hits in their order, so that a visitor may ask for all layers),
`node_count`, `leaf_ref_count`, `timings` (ms per stage of the last build), `arrays()` and `release()`.
"""

from __future__ import annotations

from typing import NamedTuple

import moderngl
import numpy as np

from ..errors import InputError
from ..gpu import shader
from ..gpu.buffers import TextureBuffer
from .brute import Brute
from .kdtree import KdTree
from .lbvh import Lbvh

STRUCTURES = {"kdtree": KdTree, "lbvh": Lbvh, "brute": Brute}
RAYS_UNIT, HITS_BINDING, WORK_BINDING = 11, 0, 7
NO_TRIANGLE = 0xFFFFFFFF


def make_structure(ctx: moderngl.Context, name: str):
    """A new structure of a name. Raises InputError for an unknown one."""
    if name not in STRUCTURES:
        raise InputError(f"accelerator {name!r}: expected one of {', '.join(STRUCTURES)}")
    return STRUCTURES[name](ctx)


class Hits(NamedTuple):
    """What rays met: t [N] float32 (inf: nothing), triangle [N] int (-1: nothing), weights [N, 2] float32 (barycentric
    coordinates of the second and third corner); work [N, 2] int (steps, triangle tests) when it was asked for."""

    t: np.ndarray
    triangle: np.ndarray
    weights: np.ndarray
    work: np.ndarray | None


class RayQueries:
    """Casts arrays of rays through a structure."""

    def __init__(self, ctx: moderngl.Context):
        self.ctx = ctx
        self._programs: dict[tuple, object] = {}
        self._rays = TextureBuffer(ctx, 1 << 16)
        self._hits = ctx.buffer(reserve=1 << 16, dynamic=True)
        self._work = ctx.buffer(reserve=1 << 16, dynamic=True)

    def program(self, structure, visit: str, counted: bool = False):
        """The program that casts rays through a structure; `visit` is "closest" or "any"."""
        key = structure.source, visit, counted
        if key not in self._programs:
            virtual = {
                "accel.glsl": structure.source,
                "visit.glsl": f"inputs/accel/visit_{visit}.glsl",
                "count.glsl": "inputs/accel/count_steps.glsl" if counted else "inputs/accel/count_none.glsl",
            }
            self._programs[key] = shader.compute(self.ctx, "passes/accel/rays.comp", None, virtual)
        return self._programs[key]

    def closest_hit(self, structure, origins, directions, t_min=0.0, t_max=np.inf, counted: bool = False) -> Hits:
        """The nearest hit of each ray with t_min < t < t_max.

        Parameters
        ----------
        structure : built
        origins, directions : [N, 3]; t is in units of the direction's length
        t_min, t_max : [N] or one for all
        counted : also count the steps and the triangle tests of each ray
        """
        return self._cast(structure, "closest", origins, directions, t_min, t_max, counted)

    def any_hit(self, structure, origins, directions, t_min=0.0, t_max=np.inf) -> np.ndarray:
        """Whether each ray hits anything with t_min < t < t_max: [N] bool. Parameters as for `closest_hit`."""
        return self._cast(structure, "any", origins, directions, t_min, t_max, False).triangle >= 0

    def _cast(self, structure, visit, origins, directions, t_min, t_max, counted) -> Hits:
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
        for buffer, size in ((self._hits, 16 * count), (self._work, 8 * count)):
            if buffer.size < size:
                buffer.orphan(size)
        return count

    def run(self, structure, visit: str, count: int, counted: bool = False) -> None:
        """Cast the uploaded rays; the hits stay on the GPU."""
        program = self.program(structure, visit, counted)
        structure.bind(program)
        self._rays.bind(RAYS_UNIT)
        self._hits.bind_to_storage_buffer(HITS_BINDING)
        self._work.bind_to_storage_buffer(WORK_BINDING)
        for uniforms in structure.chunks():
            values = {"ray_count": count, "front_count": count, "back_first": count, "resume": 0} | uniforms
            shader.set_uniforms(program, **values)
            program.run(-(-count // 64))
            self.ctx.memory_barrier()

    def release(self) -> None:
        """Free the GPU's memory."""
        for thing in (self._rays, self._hits, self._work, *self._programs.values()):
            thing.release()
