"""Tileable maps of a fabric for any renderer: colour, normals, height, roughness, opacity, and the yarns' shares.

Their means over a repeat are the far cloth's values, so that the cloth looks the same from afar.   [own]
"""

from __future__ import annotations

import io
from dataclasses import dataclass

import numpy as np
from PIL import Image

from ..color import srgb_encode
from ..fabric import Fabric
from ..methods.weave_maps import fabric_maps, repeat_of

LARGEST = 2048  # texels a side
FLAT = 8  # texels a side of a fabric without a weave
SIZE = 0.01  # metres a side of it


@dataclass(frozen=True)
class Textures:
    """One repeat, [H, W] each, top row first: v grows upward, u to the right; the warp runs along u.

    color : [H, W, 3] linear, mean `base`. normal : [H, W, 3] unit, x along u, y along v. height : metres, mean 0.
    roughness : mean `roughness`. opacity : 0 in holes. share : [H, W, 3], warp, weft and hole. size : metres along u and v.
    rel : [T, h, w], tangents' shares over their share of the whole cloth, one repeat of the structure; None without a weave.
    """

    color: np.ndarray
    normal: np.ndarray
    height: np.ndarray
    roughness: np.ndarray
    opacity: np.ndarray
    share: np.ndarray
    size: tuple[float, float]
    rel: np.ndarray | None

    @property
    def has_holes(self) -> bool:
        """Whether anything shows through."""
        return bool((self.opacity < 1.0).any())


def make_textures(fabric: Fabric, base: tuple[float, float, float], roughness: float) -> Textures:
    """The maps of a fabric; `base` and `roughness` are the far cloth's. Without a weave they are even."""
    if fabric.weave is None:
        return _even(fabric, base, roughness)
    maps = fabric_maps(fabric)
    tile = fabric.weave.tile(maps.hole.shape)
    at = _places(tile, repeat_of(fabric), maps.size)
    share, system = maps.share[:, *at], tile.system[at]
    albedo = _albedos(fabric, tile, at)
    color = np.einsum("jhw,jhwc->hwc", share, albedo)
    mean = color.mean((0, 1))
    color = np.clip(np.asarray(base) * color / np.where(mean > 0, mean, 1.0), 0.0, 1.0)
    width = np.array([yarn.gamma_s_deg for yarn in fabric.yarn]) ** 0.5
    rough = np.where(system == 1, width[1], width[0])
    hole = maps.hole[at] > 0.5
    layers = [
        color, _normals(fabric, maps, at, system), maps.height[at],
        np.clip(roughness * rough / rough.mean(), 0.02, 1.0), 1.0 - hole,
        np.stack([*share, hole], -1),
    ]  # fmt: skip
    return Textures(*(layer[::-1] for layer in layers), repeat_of(fabric), maps.rel)


def _places(tile, repeat: tuple[float, float], size: tuple[float, float]) -> tuple[np.ndarray, np.ndarray]:
    """Rows and columns of the structure's maps for each texel of a whole repeat, colours included."""
    axes = []
    for n, whole, one in zip(tile.system.shape, repeat[::-1], size[::-1], strict=True):
        count = max(round(whole / one), 1)
        axes.append(np.arange(min(n * count, LARGEST)) * (n * count) // min(n * count, LARGEST) % n)
    rows, columns = np.meshgrid(*axes, indexing="ij")
    return rows, columns


def _albedos(fabric: Fabric, tile, at) -> np.ndarray:
    """[2, H, W, 3]: the colour of the warp and of the weft thread at each texel."""
    assert fabric.weave is not None
    H, W = at[0].shape
    colors = fabric.weave.thread_colors
    if colors is None:
        return np.broadcast_to(np.array([y.albedo for y in fabric.yarn])[:, None, None], (2, H, W, 3))
    picks, ends = tile.threads
    all_picks, all_ends = (int(np.lcm(n, len(c))) for n, c in zip((picks, ends), colors[::-1], strict=True))
    warp = ((np.arange(H) + 0.5) / H * all_ends).astype(int)
    weft = ((np.arange(W) + 0.5) / W * all_picks).astype(int)
    out = np.empty((2, H, W, 3))
    out[0], out[1] = colors[0][warp % len(colors[0])][:, None], colors[1][weft % len(colors[1])][None]
    # A thread may lie over its neighbour's strip: the nearest of its number in the repeat.
    thread, system = tile.thread[at], tile.system[at]
    for j, (place, n) in enumerate(((warp[:, None], ends), (weft[None], picks))):
        number = thread + n * np.rint((place - thread) / n).astype(int)
        mine = system == j
        out[j][mine] = colors[j][number[mine] % len(colors[j])]
    return out


def _normals(fabric: Fabric, maps, at, system: np.ndarray) -> np.ndarray:
    """[H, W, 3]: the yarn's own up, tilted along it and rolled to its sides; straight up in holes."""
    weights, yarn = fabric.weights[:, 1], np.array([t.yarn for t in fabric.tangents])
    tilts = np.array([t.tilt for t in fabric.tangents])
    N = np.zeros((*system.shape, 3))
    N[..., 2] = 1.0
    for j, (along, aside) in enumerate(((0, 1), (1, 0))):
        own = weights[yarn == j, None, None] * maps.rel[yarn == j].astype(float)
        total = np.maximum(own.sum(0), 1e-9)
        tilt = ((own * np.sin(tilts[yarn == j])[:, None, None]).sum(0) / total)[at]
        roll = (fabric.weave.roll * maps.roll[j] / np.where(maps.share[j] > 0, maps.share[j], 1.0))[at]
        mine = system == j
        N[mine, along], N[mine, aside] = tilt[mine], roll[mine]
    flat = np.minimum(np.hypot(N[..., 0], N[..., 1]), 0.95)
    scale = flat / np.maximum(np.hypot(N[..., 0], N[..., 1]), 1e-9)
    N[..., :2] *= np.where(scale > 0, scale, 1.0)[..., None]
    N[..., 2] = np.sqrt(1.0 - (N[..., :2] ** 2).sum(-1))
    return N


def _even(fabric: Fabric, base, roughness: float) -> Textures:
    one = np.ones((FLAT, FLAT))
    share = np.stack([fabric.yarn[0].area * one, fabric.yarn[1].area * one, fabric.gap * one], -1)
    up = np.stack([0 * one, 0 * one, one], -1)
    return Textures(np.asarray(base) * one[..., None], up, 0 * one, roughness * one, one, share, (SIZE, SIZE), None)


# -- as files ----------------------------------------------------------------------------------------------------------


def png(values: np.ndarray, srgb: bool = False) -> bytes:
    """Values 0 to 1, [H, W] or [H, W, C], as a PNG file of 8 bits; `srgb` encodes colours."""
    values = srgb_encode(values) if srgb else values
    buffer = io.BytesIO()
    Image.fromarray(np.round(255 * np.clip(values, 0, 1)).astype(np.uint8)).save(buffer, "png")
    return buffer.getvalue()


def png16(values: np.ndarray) -> bytes:
    """Values 0 to 1, [H, W], as a PNG file of 16 bits."""
    buffer = io.BytesIO()
    Image.fromarray(np.round(65535 * np.clip(values, 0, 1)).astype(np.uint16)).save(buffer, "png")
    return buffer.getvalue()


def normal_map(textures: Textures) -> np.ndarray:
    """Normals as colours, OpenGL's way: green is up."""
    return 0.5 + 0.5 * textures.normal
