"""What maps of threads show from the side, in the mean: yarns that hide each other, on the GPU.   [own, facts-weave 4]

A ray of view meets the yarns' heights elsewhere than the middle plane, so from the side a repeat shows more of some tangents
and less of others. The far field knows that already: masking is part of it. So what is seen is divided by its mean over a
repeat, from the table that is made here by the same search.
"""

from __future__ import annotations

from typing import Any

import moderngl
import numpy as np

from ..gpu.buffers import Buffer
from ..gpu.programs import programs
from ..weave.maps import Maps

SIDE = 17  # texels of the table, of directions as a disk
MOST_LEVELS = 9  # mip levels that have one; where maps are coarser, yarns have no height
SAMPLES = 256, 4096  # of a repeat, at least and at most


def relief_heights(maps: Maps, relief: float) -> np.ndarray:
    """(metres of a unit of the map's heights, the highest and the lowest place in units)."""
    unit = float(np.abs(maps.height).max()) or 1.0
    return np.array([relief * unit, maps.height.max() / unit, maps.height.min() / unit], "f4")


def relief_table(
    ctx: moderngl.Context, inputs: dict[str, Any], groups: int, size: tuple[int, int], flat: bool = False
) -> moderngl.Texture3D:
    """Means of rel, of turn and of the holes over a repeat, from each direction: texture [(2 groups + 1) levels, SIDE, SIDE].

    inputs : what inputs/methods/relief.glsl reads. size : (H, W) of the maps.
    flat : yarns have no height, so one level and one place serve.
    """
    levels = 1 if flat else min(max(size).bit_length(), MOST_LEVELS)
    texels = [max(size[0] >> n, 1) * max(size[1] >> n, 1) for n in range(levels)]
    counts = np.zeros(16, "i4")
    counts[:levels] = np.clip(4 * np.array(texels), *SAMPLES)
    each = " ".join(f"F({g});" for g in range(groups))
    program = programs(ctx).compute("passes/methods/relief_table.comp", {"GROUPS": groups, "EACH_GROUP(F)": each})
    layers = (2 * groups + 1) * levels
    means = Buffer(ctx, 16 * SIDE * SIDE * layers)
    program.run(SIDE * SIDE * levels, inputs, Means=means, table_side=SIDE, levels=levels, sample_counts=counts)
    table = ctx.texture3d((SIDE, SIDE, layers), 4, means.read(16 * SIDE * SIDE * layers), dtype="f4")
    means.buffer.release()
    table.filter = moderngl.LINEAR, moderngl.LINEAR
    table.repeat_x = table.repeat_y = table.repeat_z = False
    return table
