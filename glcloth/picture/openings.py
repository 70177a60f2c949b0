"""Opacity maps: where cloth is not, by a picture over its UVs.   [own]"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import moderngl
import numpy as np

from ..color import luminance
from ..geometry.mesh import Mesh
from ..gpu.buffers import TextureBuffer
from ..gpu.context_local import of_context
from ..gpu.gbuffer import CutOut
from ..gpu.pictures import even_size, picture_array, resampled
from ..image import decode_codes, read_image
from ..scene import ClothMap
from .masks import PLACES, Masked, MaskTextures
from .prints import texel_means


@dataclass(frozen=True, eq=False)
class Opacity:
    """An opacity map.

    Parameters
    ----------
    shares : [H, W, 1] 0 open to 1 closed, the first row at v = 0
    repeat : what one repeat covers, along u and v
    in_metres : whether that is in metres and not in UV units
    """

    shares: np.ndarray
    repeat: tuple[float, float]
    in_metres: bool


def load_opacity(entry: ClothMap) -> Opacity:
    """Read an opacity map: the alpha of a picture that has some, else its codes, as they are. Raises InputError as
    `read_image`."""
    path = Path(entry.file)
    picture = read_image(path)
    if path.suffix.lower() in (".png", ".jpg", ".jpeg"):
        picture = decode_codes(path)
    alpha = picture.shape[2] == 4 and picture[..., 3].min() < 1.0
    shares = picture[..., 3] if alpha else luminance(picture[..., :3])
    shares = np.nan_to_num(np.asarray(shares, np.float32)[::-1, :, None]).clip(0.0, 1.0)
    height = entry.repeat * shares.shape[0] / shares.shape[1] if entry.unit == "m" else entry.repeat
    return Opacity(shares, (entry.repeat, height), entry.unit == "m")


def mostly_closed(mesh: Mesh, opacity: Opacity, scale: float) -> np.ndarray:
    """The triangles [T] of which more than half is closed. Rays know no map: these hide light wholly, others not at all."""
    assert mesh.uv is not None
    uv = np.nan_to_num(np.asarray(mesh.uv, float)[mesh.triangles]) * (scale / np.array(opacity.repeat))
    return texel_means(opacity.shares, np.einsum("kc,tcd->ktd", PLACES, uv))[..., 0].mean(0) > 0.5


def open_last(mesh: Mesh, hides: np.ndarray) -> tuple[Mesh, int]:
    """The mesh with the triangles [T] that hide no light behind the others, and how many those others are, one at least."""
    order = np.argsort(~hides, kind="stable")
    part_of = None if mesh.part_of is None else mesh.part_of[order]
    return replace(mesh, triangles=mesh.triangles[order], part_of=part_of), max(int(hides.sum()), 1)


class CutTextures:
    """An opacity map and a fabric mask on the GPU, as passes/picture/surface.frag reads them with the UVs of one mesh."""

    def __init__(self, ctx: moderngl.Context):
        self.ctx = ctx
        self._uv = TextureBuffer(ctx, 16)
        self._texture: moderngl.TextureArray | None = None
        self._numbers: np.ndarray | None = None  # of a mask whose texture it uses

    def cut_out(self, mesh: Mesh, opacity: Opacity | None, scale: float, mask: Masked | None) -> CutOut:
        """Take the maps of a mesh, whose UV unit is `scale` of the opacity map's repeat."""
        assert mesh.uv is not None
        masks, before = of_context(MaskTextures, self.ctx), self._numbers
        if self._texture is not None:
            self._texture.release()
        self._texture = self._numbers = None
        self._uv.write(np.pad(mesh.uv, ((0, 0), (0, 2))).astype("f4"))
        found: dict[str, Any] = {}
        if opacity is not None:
            size = even_size(*opacity.shares.shape[:2])
            self._texture = picture_array(self.ctx, resampled(opacity.shares, size)[None])
            repeats = scale / opacity.repeat[0], scale / opacity.repeat[1]
            found = {"opacity_map": self._texture, "opacity_repeats": repeats}
        if mask is not None:
            self._numbers = mask.numbers
            repeats = 1.0 / mask.repeat[0], 1.0 / mask.repeat[1]
            found |= {"mask_map": masks.take(mask.numbers), "mask_repeats": repeats, "mask_number": mask.number}
        if before is not None:
            masks.give_back(before)
        return CutOut(self._uv, found)
