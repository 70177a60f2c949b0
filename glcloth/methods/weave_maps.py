"""The maps that show threads near by, on the GPU: what inputs/methods/weave.glsl reads of a fabric with a weave."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

import moderngl
import numpy as np
from OpenGL import GL

from ..fabric import Fabric
from ..gpu.layout import shared
from ..gpu.memo import Last
from ..weave.levels import levels_of, side_by_side
from ..weave.maps import Maps, mip_levels
from ..weave.tile import tile_size
from .relief import LEVELS, PER_LEVEL, first_level, relief_heights, relief_table

FAR_YARNS, FAR_REPEATS = 2.0, 0.5  # yarns in a pixel, or repeats if these are more, from which on it shows none


def repeat_of(fabric: Fabric) -> tuple[float, float]:
    """Metres along u and v after which structure and colours repeat."""
    assert fabric.weave is not None
    picks, ends = fabric.weave.drafted.structure
    if (colors := fabric.weave.thread_colors) is not None:
        ends, picks = int(np.lcm(ends, len(colors[0]))), int(np.lcm(picks, len(colors[1])))
    return 0.01 * picks / fabric.weave.picks_per_cm, 0.01 * ends / fabric.weave.ends_per_cm


def far_footprint(fabric: Fabric) -> float:
    """Metres: a pixel that covers so much of the cloth, on its shorter side, shows no thread and no pattern of threads:
    pixels cannot draw what repeats faster than every two of them."""
    assert fabric.weave is not None
    yarn = 0.01 / min(fabric.weave.ends_per_cm, fabric.weave.picks_per_cm)
    if fabric.weave.drafted.pile:
        return FAR_YARNS * yarn  # its repeat is no pattern
    return max(FAR_YARNS * yarn, *(FAR_REPEATS * side for side in repeat_of(fabric)))


STRAND = 0.09  # mm, a bundle of some fibres
FEWEST, MOST = 6.0, 14.0  # across a yarn: thin yarns show fewer fibres, but not none
LONG = 12.0  # length of a strand over its width
NOISE = 256  # texels a side
YARN_TEXELS = 4  # a yarn has where the maps' versions begin to be mip levels
MOST_LEVELS = int(shared("inputs/methods/levels.glsl")[0]["MOST_LEVELS"])
MOST_TAPS = 8.0  # places at which a pixel reads the maps


class WeaveMaps:
    """Textures of one repeat of a fabric's weave, in versions whose means are those of the whole (weave/levels.py)."""

    def __init__(self, ctx: moderngl.Context):
        self.ctx = ctx
        self._made: Last[dict[str, Any]] = Last()
        self._relief: Last[moderngl.TextureArray] = Last()
        self._textures: list[moderngl.Texture | moderngl.TextureArray] = []
        self._relief_table: moderngl.TextureArray | None = None
        self._noise = level_inputs(ctx, "noise", _noise()[None], NOISE)

    def inputs(self, fabric: Fabric, groups: int, lanes: int) -> dict[str, Any]:
        """The maps of a fabric, its tangents packed by so many to a vec4."""
        return self._made.get(lambda: self._make(fabric, groups, lanes), fabric, groups, lanes)

    def _make(self, fabric: Fabric, groups: int, lanes: int) -> dict[str, Any]:
        assert fabric.weave is not None
        self._release_maps()
        maps = fabric_maps(fabric)
        holes = np.zeros((1, 4, *maps.hole.shape), np.float32)
        holes[0, 0] = maps.hole
        layers = np.concatenate([thread_layers(fabric, maps, groups, lanes), holes])
        colors, size, colored = color_layers(fabric, maps)
        end = fine_end(fabric, maps.hole.shape, maps.size)
        threads = level_inputs(self.ctx, "weave", layers, end)
        of_color = level_inputs(self.ctx, "color", colors, fine_end(fabric, colors.shape[2:], size))
        self._textures = [threads["weave_levels"], of_color["color_levels"]]
        repeats = 1.0 / maps.size[0], 1.0 / maps.size[1]
        read = {**threads, "weave_repeats": repeats}
        if fabric.weave.relief:
            unit = float(relief_heights(maps, 1.0)[0])
            read["height_levels"] = self._heights(maps.height / unit, end)
        loose, twist = fabric.weave.irregularity, np.radians(fabric.weave.twist_deg)
        return {
            "hole_mean": float(maps.hole.mean()),
            **of_color,
            "colored": colored,
            **read,
            **self._side_view(fabric, maps, layers, groups, read),
            "color_repeats": (1.0 / size[0], 1.0 / size[1]),
            **self._noise,
            "yarns": (100.0 * fabric.weave.picks_per_cm, 100.0 * fabric.weave.ends_per_cm),
            "irregular": (loose.shift, loose.length, loose.yarn, loose.fibre),
            "fibres": (strands_across(fabric), LONG, -np.tan(twist[0]), np.tan(twist[1])),
            "most_taps": MOST_TAPS,
            **even_shares(fabric, groups, lanes),
            "weave_A": np.array([y.albedo for y in fabric.yarn], "f4"),
        }

    def _side_view(
        self, fabric: Fabric, maps: Maps, layers: np.ndarray, groups: int, read: dict[str, Any]
    ) -> dict[str, Any]:
        """What inputs/methods/relief.glsl reads beside the maps, and the table, where yarns hide each other."""
        weave = fabric.weave
        if weave is None or not weave.relief:
            return {}
        # The table takes longer than a hand is ready to wait; the first answer to an edit does without.
        relief = 0.0 if weave.is_sketch else weave.relief
        shape = (
            weave.draft,
            *(getattr(weave.shape, field.name) for field in fields(weave.shape) if field.name != "draft"),
        )
        picks, ends = weave.drafted.structure
        size = maps.hole.shape
        first, hole = first_level(size, (ends, picks)), float(maps.hole.mean())
        read = {**read, "relief_heights": relief_heights(maps, relief), "relief_end": first + (LEVELS - 1) / PER_LEVEL}
        table = self._relief.get(
            lambda: self._table(
                relief_table(self.ctx, read, (layers, maps.height), groups, first, hole, relief == 0.0)
            ),
            *(
                shape,
                weave.occlusion,
                weave.roll,
                relief,
                tuple(fabric.tangents),
                fabric.weights.tobytes(),
                groups,
                size,
            ),
        )
        levels = first, table.layers // (2 * groups + 1), PER_LEVEL
        return {**read, "relief_table": table, "relief_levels": np.array(levels, "f4")}

    def _table(self, table: moderngl.TextureArray) -> moderngl.TextureArray:
        """The new table in place of the old one."""
        if self._relief_table is not None:
            self._relief_table.release()
        self._relief_table = table
        return table

    def _heights(self, heights: np.ndarray, end: int) -> moderngl.Texture:
        """A texture of single floats of heights [H, W], as the maps lie in theirs."""
        picture = side_by_side(heights.astype("f4"), levels_of(*heights.shape, end))
        texture = self.ctx.texture(picture.shape[::-1], 1, picture, dtype="f4")
        texture.filter = moderngl.LINEAR, moderngl.LINEAR
        texture.repeat_x = texture.repeat_y = False
        self._textures.append(texture)
        return texture

    def _release_maps(self) -> None:
        for texture in self._textures:
            texture.release()
        self._textures = []

    def release(self) -> None:
        """Free the GPU's memory."""
        self._release_maps()
        self._noise["noise_levels"].release()
        if self._relief_table is not None:
            self._relief_table.release()
            self._relief_table = None
            self._relief.forget()


def strands_across(fabric: Fabric) -> float:
    """How many strands of fibres lie side by side in a yarn: thick woollen ones show more of them than thin silk does."""
    assert fabric.weave is not None
    spacing = 20.0 / (fabric.weave.ends_per_cm + fabric.weave.picks_per_cm)  # mm
    return float(np.clip(spacing / STRAND, FEWEST, MOST))


def _noise() -> np.ndarray:
    """Four independent values of mean 0 and deviation 1 a texel, [4, NOISE, NOISE]."""
    values = np.random.default_rng(3).normal(size=(NOISE, NOISE, 4)).clip(-2.0, 2.0)
    values = (values - values.mean((0, 1))) / values.std((0, 1))
    return np.ascontiguousarray(np.moveaxis(values, -1, 0), "f4")


def level_inputs(ctx: moderngl.Context, name: str, layers: np.ndarray, end: int) -> dict[str, Any]:
    """What inputs/methods/levels.glsl reads of layers [N, 4, H, W]: NAME_levels, NAME_rects, NAME_sizes and NAME_steps; `end` :
    as weave/levels.py has it."""
    height, width = layers.shape[2:]
    levels = levels_of(height, width, end)
    picture = np.moveaxis(side_by_side(layers.astype("f4", copy=False), levels, "f2"), 1, -1)
    texture = ctx.texture_array((*levels.shape[::-1], len(layers)), 4, np.ascontiguousarray(picture), dtype="f2")
    texture.filter = moderngl.LINEAR, moderngl.LINEAR
    texture.repeat_x = texture.repeat_y = False
    rects = np.zeros((MOST_LEVELS, 4), "f4")
    rects[: len(levels.sizes)] = levels.rects
    own = {"levels": texture, "rects": rects, "sizes": (width, height)}
    own["steps"] = float(levels.whole), float(levels.end), float(len(levels.sizes))
    return {f"{name}_{key}": value for key, value in own.items()}


def fine_end(fabric: Fabric, shape: tuple[int, ...], size: tuple[float, float]) -> int:
    """The mip level of maps [H, W], of `size` metres along u and v, up to which they have versions between their mip levels."""
    assert fabric.weave is not None
    if fabric.weave.is_sketch:
        return 0
    texels = [n / (100.0 * threads * side) for n, threads, side in zip(
        shape[::-1], (fabric.weave.picks_per_cm, fabric.weave.ends_per_cm), size, strict=True)]  # fmt: skip
    return max(int(np.floor(np.log2(min(texels) / YARN_TEXELS))), 0)


def texture_array(ctx: moderngl.Context, layers: np.ndarray, kind: str = "f2") -> moderngl.TextureArray:
    """A texture array of layers [N, 1 or 4, H, W]; its levels are made here, for drivers round half floats down.

    kind : "f2", half floats, or "f4", single floats
    """
    count, components, height, width = layers.shape
    texture = ctx.texture_array((width, height, count), components, dtype=kind)
    texture.build_mipmaps()  # makes room
    texture.filter = moderngl.LINEAR_MIPMAP_LINEAR, moderngl.LINEAR
    of_texel, of_value = GL.GL_RGBA if components == 4 else GL.GL_RED, GL.GL_HALF_FLOAT if kind == "f2" else GL.GL_FLOAT
    GL.glBindTexture(GL.GL_TEXTURE_2D_ARRAY, texture.glo)
    for level, means in enumerate(mip_levels(layers)):
        data = np.ascontiguousarray(np.moveaxis(means, 1, -1), kind)
        size = (data.shape[2], data.shape[1], count)
        GL.glTexSubImage3D(GL.GL_TEXTURE_2D_ARRAY, level, 0, 0, 0, *size, of_texel, of_value, data.tobytes())
    GL.glBindTexture(GL.GL_TEXTURE_2D_ARRAY, 0)
    return texture


def thread_layers(fabric: Fabric, maps: Maps, groups: int, lanes: int) -> np.ndarray:
    """`groups` layers of rel, then of turn, [2 groups, 4, H, W], of tangents packed by so many to a vec4."""
    assert fabric.weave is not None
    layers = np.zeros((2, groups, 4, *maps.hole.shape), np.float32)
    side = fabric.weave.roll * maps.roll / np.where(maps.share > 0.0, maps.share, 1.0)
    for t, (tangent, rel) in enumerate(zip(fabric.tangents, maps.rel, strict=True)):
        layers[0, t // lanes, t % lanes] = rel
        layers[1, t // lanes, t % lanes] = rel * side[tangent.yarn]
    return layers.reshape(-1, *layers.shape[2:])


def color_layers(fabric: Fabric, maps: Maps) -> tuple[np.ndarray, tuple[float, float], bool]:
    """The colours of warp and of weft [2, 4, H, W], the size of their map in metres, and whether threads have some."""
    assert fabric.weave is not None
    colored = fabric.weave.color_map(maps)
    colors, size = (np.zeros((2, 1, 1, 4)), (1.0, 1.0)) if colored is None else colored
    return np.moveaxis(colors, -1, 1), size, colored is not None


def fabric_maps(fabric: Fabric) -> Maps:
    """The maps of a fabric's tangents in their order."""
    assert fabric.weave is not None
    yarn = np.array([tangent.yarn for tangent in fabric.tangents])
    tilt = np.degrees([tangent.tilt for tangent in fabric.tangents])
    of_yarn = [yarn == j for j in (0, 1)]
    weights = [fabric.weights[mine, 1] for mine in of_yarn]
    size = tile_size(*fabric.weave.drafted.structure)
    return fabric.weave.maps([tilt[mine] for mine in of_yarn], weights, size, np.float32)


def packed(values: np.ndarray, groups: int, lanes: int) -> np.ndarray:
    """Values of tangents as `groups` vec4s that hold `lanes` each, the rest 0."""
    out = np.zeros(groups * lanes, "f4")
    out[: len(values)] = values
    return np.ascontiguousarray(np.pad(out.reshape(groups, lanes), ((0, 0), (0, 4 - lanes))))


def even_shares(fabric: Fabric, groups: int, lanes: int) -> dict[str, np.ndarray]:
    """What inputs/methods/even.glsl reads: shares of the tangents of warp and of weft in what cloth reflects of even light."""
    shares = fabric.weights[:, 0] / fabric.weights[:, 0].sum()
    of_weft = np.array([tangent.yarn == 1 for tangent in fabric.tangents])
    return {
        "even_warp": packed(np.where(of_weft, 0.0, shares), groups, lanes),
        "even_weft": packed(np.where(of_weft, shares, 0.0), groups, lanes),
    }
