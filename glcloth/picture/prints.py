"""Prints: a picture over the UVs of a cloth, by which the colours of its yarns are multiplied.   [own]

A printed cloth is two things: its fabric, dyed in the mean colour of the print on this cloth, and the print over that mean. So
what knows no places, as a bounce or far cloth, is right in the mean.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import moderngl
import numpy as np

from ..geometry.mesh import Mesh
from ..gpu.memo import Last
from ..gpu.pictures import even_size, picture_array, resampled
from ..image import decode_codes, read_image
from ..scene import PrintMap
from .uv_pictures import MIDDLES, has_codes, lie, texel_means, uv_places

TAPS = 8.0  # places at which a pixel reads the print
MEAN_SIDE = 64  # texels a side of the picture that the mean is read from


@dataclass(frozen=True, eq=False)
class Print:
    """A print as a picture.

    Parameters
    ----------
    colors : [H, W, 3] linear, the first row at v = 0
    repeat : what one repeat covers, along u and v
    in_metres : whether that is in metres and not in UV units
    """

    colors: np.ndarray
    repeat: tuple[float, float]
    in_metres: bool

    def at(self, uv: np.ndarray) -> np.ndarray:
        """The colours [N, 3] at places [N, 2] in the units of the repeat, linear between texels."""
        return texel_means(self.colors, uv / self.repeat)

    def mean_on(self, mesh: Mesh, scale: float) -> np.ndarray:
        """The mean colour [3] on a mesh, whose UV unit is `scale` of the repeat's."""
        size = tuple(min(side, MEAN_SIDE) for side in self.colors.shape[:2])
        coarse = resampled(self.colors, (size[0], size[1]))
        p = np.asarray(mesh.positions, float)[mesh.triangles]
        area = np.linalg.norm(np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]), axis=1)
        places = uv_places(mesh, MIDDLES) * (scale / np.array(self.repeat))
        values = texel_means(coarse, places).mean(0)
        return (area[:, None] * values).sum(0) / max(area.sum(), 1e-30)


def load_print(entry: PrintMap) -> Print:
    """Read the picture of a print. Raises InputError as `read_image`."""
    picture = read_image(entry.file)
    if entry.space == "linear" and has_codes(entry.file):
        picture = decode_codes(Path(entry.file))
    colors = np.nan_to_num(np.asarray(picture[::-1, :, :3], np.float32), posinf=65504.0).clip(0.0, 65504.0)
    return Print(colors, *lie(entry, colors))


class PrintTexture:
    """A print over its mean on the GPU, as inputs/picture/print.glsl reads it."""

    def __init__(self, ctx: moderngl.Context):
        self.ctx = ctx
        self._made: Last[moderngl.TextureArray] = Last(frees=True)

    def inputs(self, of: Print, mean: np.ndarray, scale: float) -> dict[str, Any]:
        """Textures and uniforms; `scale`: metres of `PixelUv` in a unit of the repeat."""
        texture = self._made.get(lambda: self._make(of, mean), of, mean)
        return {
            "print_map": texture,
            "print_mean": mean,
            "print_repeats": tuple(1.0 / (scale * side) for side in of.repeat),
            "print_taps": TAPS,
        }

    def _make(self, of: Print, mean: np.ndarray) -> moderngl.TextureArray:
        ratio = of.colors / np.where(mean > 0.0, mean, 1.0)
        return picture_array(self.ctx, resampled(ratio, even_size(*of.colors.shape[:2]))[None])
