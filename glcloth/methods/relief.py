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

SIDE = 21  # texels of the table, of directions as a disk
# Of 17 the mean of heavy linen is 1.0 % off at 40 degrees, of 21 0.6 %.
FINEST = 32.0  # texels a yarn, from where on the mip levels show the same,
PER_LEVEL = 4  # how many tables from one mip level to the next: drivers round levels, so the means run in steps
LEVELS = 4 * PER_LEVEL + 1  # in the last a texel is half a yarn, and yarns have no height
SAMPLES = 4096  # of a repeat in the finest; half as many from one mip level to the next, where maps are smoother


def relief_heights(maps: Maps, relief: float) -> np.ndarray:
    """(metres of a unit of the map's heights, the highest and the lowest place in units)."""
    unit = float(np.abs(maps.height).max()) or 1.0
    return np.array([relief * unit, maps.height.max() / unit, maps.height.min() / unit], "f4")


def first_level(size: tuple[int, int], threads: tuple[int, int]) -> int:
    """The finest mip level in the table; size : (H, W) of the maps, threads : (ends, picks) of the repeat."""
    texels = max(n / count for n, count in zip(size, threads, strict=True))
    return max(int(np.floor(np.log2(texels / FINEST))), 0)


def relief_table(
    ctx: moderngl.Context, inputs: dict[str, Any], groups: int, first: int, hole: float, flat: bool = False
) -> moderngl.Texture3D:
    """Means of rel, of turn and of the holes over a repeat, from each direction: texture [(2 groups + 1) LEVELS, SIDE, SIDE].

    inputs : what inputs/methods/relief.glsl reads. first : `first_level`. hole : mean share of holes.
    flat : yarns have no height, so one level serves.
    """
    levels = 1 if flat else LEVELS
    each = " ".join(f"F({g});" for g in range(groups))
    defines = {"GROUPS": groups, "EACH_GROUP(F)": each}
    program = programs(ctx).compute("passes/methods/relief_table.comp", defines)
    layers = (2 * groups + 1) * levels
    means = Buffer(ctx, 16 * SIDE * SIDE * layers)
    own = {"table_side": SIDE, "first_level": first, "levels": levels, "per_level": PER_LEVEL, "sample_count": SAMPLES}
    program.run(SIDE * SIDE * levels, inputs, own, Means=means)
    values = np.frombuffer(means.read(16 * SIDE * SIDE * layers), "f4").reshape(-1, levels, SIDE, SIDE, 4).copy()
    values[:groups, -1], values[groups:-1, -1], values[-1, -1] = 1.0, 0.0, hole  # without heights they are known
    table = ctx.texture3d((SIDE, SIDE, layers), 4, values.tobytes(), dtype="f4")
    means.buffer.release()
    table.filter = moderngl.LINEAR, moderngl.LINEAR
    table.repeat_x = table.repeat_y = table.repeat_z = False
    return table
