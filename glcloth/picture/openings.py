"""Opacity maps: where cloth is not, by a picture over its UVs.   [own]"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ..color import luminance
from ..geometry.mesh import Mesh
from ..image import decode_codes, read_image
from ..scene import ClothMap
from .uv_pictures import FOUR_PLACES, has_codes, lie, texel_means, uv_places


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
    if has_codes(path):
        picture = decode_codes(path)
    alpha = picture.shape[2] == 4 and picture[..., 3].min() < 1.0
    shares = picture[..., 3] if alpha else luminance(picture[..., :3])
    shares = np.nan_to_num(np.asarray(shares, np.float32)[::-1, :, None]).clip(0.0, 1.0)
    return Opacity(shares, *lie(entry, shares))


def mostly_closed(mesh: Mesh, opacity: Opacity, scale: float) -> np.ndarray:
    """The triangles [T] of which more than half is closed. Rays know no map: these hide light wholly, others not at all."""
    places = uv_places(mesh, FOUR_PLACES) * (scale / np.array(opacity.repeat))
    return texel_means(opacity.shares, places)[..., 0].mean(0) > 0.5


def open_last(mesh: Mesh, hides: np.ndarray) -> tuple[Mesh, int]:
    """The mesh with the triangles [T] that hide no light behind the others, and how many those others are, one at least."""
    order = np.argsort(~hides, kind="stable")
    part_of = None if mesh.part_of is None else mesh.part_of[order]
    return replace(mesh, triangles=mesh.triangles[order], part_of=part_of), max(int(hides.sum()), 1)
