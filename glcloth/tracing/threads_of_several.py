"""The maps of threads and holes of a scene with several fabrics, in one texture each: a run of layers is a fabric's.   [own]

Layers have one size, that of the largest map: the others are repeated until they fill it. All sides are powers of two, so that
texels and mip levels of a repeated map are those of the map itself.
"""

from __future__ import annotations

from typing import Any

import moderngl
import numpy as np

from ..fabric import Fabric
from ..gpu.memo import Last
from ..methods.weave_maps import color_layers, fabric_maps, far_footprint, packed, texture_array, thread_layers
from .shot import HangingGrid

NO_PLACE = HangingGrid(0, 1, (1.0, 1.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
NEVER = 1e-9  # metres in a pixel from which on no thread shows: always


class ThreadsOfSeveral:
    """What inputs/tracing/holes.glsl and threads.glsl read where FABRICS is defined, on one context."""

    def __init__(self, ctx: moderngl.Context):
        self.ctx = ctx
        self._made: Last[dict[str, Any]] = Last()
        self._textures: list[moderngl.TextureArray] = []

    def inputs(self, fabrics: tuple[Fabric, ...], grids: tuple[HangingGrid | None, ...], lanes: int) -> dict[str, Any]:
        """The maps, and where each fabric's cloth lies on them. grids : of each fabric; None: it shows no threads."""
        placed = tuple(grid is not None for grid in grids)
        each = [grid or NO_PLACE for grid in grids]
        return {
            **self._made.get(lambda: self._make(fabrics, placed, lanes), placed, lanes, *fabrics),
            "hole_grids": np.array([(one.first, one.quads, one.count or 1 << 30) for one in each], "i4"),
            "quad_sizes": np.array([one.size for one in each], "f4"),
        }

    def _make(self, fabrics: tuple[Fabric, ...], placed: tuple[bool, ...], lanes: int) -> dict[str, Any]:
        self.release()
        groups_of = [-(-len(fabric.tangents) // lanes) for fabric in fabrics]
        holes: list[np.ndarray] = []
        threads: list[np.ndarray] = []
        colors: list[np.ndarray] = []
        hole_of, thread_of, color_of = np.zeros((3, len(fabrics), 4), "f4")
        for k, (fabric, here) in enumerate(zip(fabrics, placed, strict=True)):
            hole_of[k] = 1.0, 1.0, 0.0, NEVER
            thread_of[k] = 1.0, 1.0, sum(len(run) for run in threads), 1.0
            color_of[k] = 1.0, 1.0, 2 * k, 0.0
            if fabric.weave is None or not here:
                # As far away: no place is a hole, and all places are alike.
                holes.append(np.zeros((1, 1, 1, 1), "f4"))
                threads.append(np.zeros((2, 4, 1, 1), "f4"))
                colors.append(np.zeros((2, 4, 1, 1), "f4"))
                continue
            # Rays meet a sheet without thickness: yarns that hide each other from the side are no part of it.
            flat = fabric.changed(weave=fabric.weave.changed(relief=0.0))
            maps = fabric_maps(flat)
            repeats = 1.0 / maps.size[0], 1.0 / maps.size[1]
            color, color_size, colored = color_layers(flat, maps)
            hole_of[k] = *repeats, maps.hole.mean(), far_footprint(fabric)
            thread_of[k, :2], thread_of[k, 3] = repeats, groups_of[k]
            color_of[k] = 1.0 / color_size[0], 1.0 / color_size[1], 2 * k, colored
            holes.append(maps.hole[None, None])
            threads.append(thread_layers(flat, maps, groups_of[k], lanes))
            colors.append(color)
        made = {}
        for name, layers, of, kind in (
            ("hole_map", holes, hole_of, "f4"),
            ("weave_map", threads, thread_of, "f2"),
            ("color_map", colors, color_of, "f2"),
        ):
            filled, copies = alike(layers)
            of[:, :2] /= copies
            made[name] = texture_array(self.ctx, filled, kind)
            self._textures.append(made[name])
        groups = max(groups_of)
        shares = [packed(fabric.weights[:, 1] / fabric.weights[:, 1].sum(), groups, lanes) for fabric in fabrics]
        return {
            **made,
            "hole_of": hole_of,
            "thread_of": thread_of,
            "color_of": color_of,
            "weave_A": np.array([y.albedo for fabric in fabrics for y in fabric.yarn], "f4"),
            "tangent_shares": np.concatenate(shares),
            "tangent_groups": groups,
        }

    def release(self) -> None:
        """Free the GPU's memory."""
        for texture in self._textures:
            texture.release()
        self._textures = []
        self._made.forget()


def alike(runs: list[np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Runs of layers [n, C, H, W] that repeat at their edges, one behind the other in the size of the largest, and how many
    copies of each fill that [runs, 2], along u and v."""
    height, width = (max(run.shape[axis] for run in runs) for axis in (2, 3))
    copies = np.array([(width // run.shape[3], height // run.shape[2]) for run in runs])
    return np.concatenate([np.tile(run, (1, 1, v, u)) for run, (u, v) in zip(runs, copies, strict=True)]), copies
