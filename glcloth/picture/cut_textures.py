"""Opacity maps and fabric masks on the GPU: where a mesh is cut out."""

from __future__ import annotations

from typing import Any

import moderngl
import numpy as np

from ..geometry.mesh import Mesh
from ..gpu.buffers import TextureBuffer
from ..gpu.context_local import of_context
from ..gpu.gbuffer import CutOut
from ..gpu.pictures import even_size, picture_array, resampled
from .masks import Masked
from .openings import Opacity


class MaskTextures:
    """The masks of a context on the GPU, each once, however many cloths it parts."""

    def __init__(self, ctx: moderngl.Context):
        self.ctx = ctx
        self._held: dict[int, tuple[np.ndarray, moderngl.Texture, int]] = {}

    def take(self, numbers: np.ndarray) -> moderngl.Texture:
        """The texture of numbers [H, W] uint8, one user more."""
        _, texture, users = self._held.get(id(numbers)) or (None, self._made(numbers), 0)
        self._held[id(numbers)] = numbers, texture, users + 1
        return texture

    def give_back(self, numbers: np.ndarray) -> None:
        """One user less; without any it is freed."""
        _, texture, users = self._held.pop(id(numbers))
        if users > 1:
            self._held[id(numbers)] = numbers, texture, users - 1
        else:
            texture.release()

    def _made(self, numbers: np.ndarray) -> moderngl.Texture:
        height, width = numbers.shape
        texture = self.ctx.texture((width, height), 1, np.ascontiguousarray(numbers), alignment=1, dtype="u1")
        texture.filter = moderngl.NEAREST, moderngl.NEAREST
        return texture


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
