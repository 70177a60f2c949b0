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
from ..gpu.shader import flatten
from ..kept import keep, kept_path, read_kept
from ..weave.maps import Maps

PASS = "passes/methods/relief_table.comp"
SIDE = 21  # texels of the table, of directions as a disk
# Of 17 the mean of heavy linen is 1.0 % off at 40 degrees, of 21 0.6 %.
FINEST = 32.0  # texels a yarn, from where on the mip levels show the same,
PER_LEVEL = 4  # how many tables from one mip level to the next: drivers round levels, so the means run in steps
LEVELS = 4 * PER_LEVEL + 1  # in the last a texel is half a yarn, and yarns have no height
SAMPLES = 4096  # of a repeat in the finest mip level; half as many in the others, where maps are smoother
FORMAT = 1  # of the files
MOST_FILES = 200  # of a megabyte or two


def relief_heights(maps: Maps, relief: float) -> np.ndarray:
    """(metres of a unit of the map's heights, the highest and the lowest place in units)."""
    unit = float(np.abs(maps.height).max()) or 1.0
    return np.array([relief * unit, maps.height.max() / unit, maps.height.min() / unit], "f4")


def first_level(size: tuple[int, int], threads: tuple[int, int]) -> int:
    """The finest mip level in the table; size : (H, W) of the maps, threads : (ends, picks) of the repeat."""
    texels = max(n / count for n, count in zip(size, threads, strict=True))
    return max(int(np.floor(np.log2(texels / FINEST))), 0)


def relief_table(
    ctx: moderngl.Context,
    inputs: dict[str, Any],
    content: tuple[np.ndarray, ...],
    groups: int,
    first: int,
    hole: float,
    flat: bool = False,
) -> moderngl.TextureArray:
    """Means of rel, of turn and of the holes over a repeat, from each direction: texture [(2 groups + 1) LEVELS, SIDE, SIDE].

    inputs : what inputs/methods/relief.glsl reads. content : what its textures hold. first : `first_level`.
    hole : mean share of holes. flat : yarns have no height, so one level serves. The table is kept on disk.
    """
    levels = 1 if flat else LEVELS
    layers, shape = (2 * groups + 1) * levels, (2 * groups + 1, levels, SIDE, SIDE, 4)
    if flat:
        return _texture(ctx, _without_heights(np.zeros(shape, np.float32), groups, hole))
    each = " ".join(f"F({g});" for g in range(groups))
    defines = {"GROUPS": groups, "EACH_GROUP(F)": each}
    own = {"table_side": SIDE, "first_level": first, "levels": levels, "per_level": PER_LEVEL, "sample_count": SAMPLES}
    numbers = {
        name: value for name, value in inputs.items() if not isinstance(value, moderngl.Texture | moderngl.TextureArray)
    }
    text, _ = flatten(PASS, defines)
    about = FORMAT, ctx.info["GL_RENDERER"], ctx.info["GL_VERSION"], sorted(own.items()), sorted(numbers.items()), hole
    path = kept_path("relief", about, text, *content)
    values = read_kept(path, shape, np.inf)
    if values is None:
        means = Buffer(ctx, 16 * SIDE * SIDE * layers)
        programs(ctx).compute(PASS, defines).run(SIDE * SIDE * levels, inputs, own, Means=means)
        values = np.frombuffer(means.read(16 * SIDE * SIDE * layers), "f4").reshape(shape).copy()
        means.release()
        keep(path, _without_heights(values, groups, hole), MOST_FILES)
    return _texture(ctx, values)


def _without_heights(values: np.ndarray, groups: int, hole: float) -> np.ndarray:
    """The table, in whose last level yarns have no height: its means are known."""
    values[:groups, -1], values[groups:-1, -1], values[-1, -1] = 1.0, 0.0, hole
    return values


def _texture(ctx: moderngl.Context, values: np.ndarray) -> moderngl.TextureArray:
    """The table [2 groups + 1, levels, SIDE, SIDE, 4] on the GPU."""
    table = ctx.texture_array((SIDE, SIDE, values.shape[0] * values.shape[1]), 4, values.tobytes(), dtype="f4")
    table.filter = moderngl.LINEAR, moderngl.LINEAR
    table.repeat_x = table.repeat_y = False
    return table
