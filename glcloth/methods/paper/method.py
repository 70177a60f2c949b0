"""Method `paper`: paper A literally, with T from SVD-compressed tables and theta segments (Mizutani et al. 2012)."""

from __future__ import annotations

from collections.abc import Iterator

import moderngl
import numpy as np

from ...errors import InputError
from ...fabric import Fabric
from ...gpu.buffers import TextureBuffer
from ...gpu.layout import constant
from ...light.lights import Lights
from ...settings import Settings
from .precompute import inner_share, shapes_of
from .tables import azimuth_texels, check_parameters, slice_index, slices, tables_for, texel_type, tiled

AZIMUTH_UNIT, XI_UNIT, O_UNIT, INDEX_UNIT = 8, 9, 10, 11
DEEPEST = 2048  # slices of a 3D texture that every OpenGL 4.3 takes
# Loop iterations of one invocation, below llvmpipe's silent end at 65,535.
MOST_ITERATIONS = 50_000


class Paper:
    """Shades by T times I for each tangent and Gaussian.   [Miz 8-16]

    A change of the weave (tilts, areas, normalisation, width of shadowing) remakes the tables; colours, eta, k_d and
    the lobe widths are read as they are. Gaussians sharper than the last level (1500) use that level's T, which is W
    averaged over 2 degrees; their I is exact.
    """

    source = "inputs/methods/paper.glsl"

    def __init__(self, ctx):
        self._ctx = ctx
        self._textures: list[moderngl.Texture3D] = []
        self._index = TextureBuffer(ctx, 16 * int(constant("MAX_TANGENTS")))
        self._azimuth = _volume(ctx, azimuth_texels(), "f4")
        self._key = self._fabric = None

    def prepare(self, fabric: Fabric, lights: Lights, settings: Settings) -> None:
        """Make and upload the tables when the weave or their parameters changed.

        Raises InputError for segments outside 2 to 64 and for grid or contribution out of range.
        """
        if not 2 <= settings.segments <= 64:
            raise InputError(f"segments {settings.segments}: expected 2 to 64 (the paper: 6)")
        self._segments, self._count = settings.segments, len(lights.gaussians)
        if fabric is self._fabric and (settings.grid, settings.contribution) == self._key[1:]:
            return
        check_parameters(settings.grid, settings.contribution)
        key = shapes_of(fabric), settings.grid, settings.contribution
        if key != self._key:
            self._upload(tables_for(fabric, settings.grid, settings.contribution))
            self._key = key
        self._fabric = fabric

    def _upload(self, tables) -> None:
        kind = texel_type(tables)
        for texture in self._textures:
            texture.release()
        self._textures = []
        for side in (tables.xi, tables.o):
            volume, *self._tiling = tiled(slices(side), DEEPEST)
            self._textures.append(_volume(self._ctx, volume, kind))
        first = slice_index(tables)
        index = np.zeros((int(constant("MAX_TANGENTS")) + first.size, 4), "f4")
        for t, place in enumerate(tables.placements):
            index[t, :3] = place.shape, place.theta, place.phi
        index[int(constant("MAX_TANGENTS")) :, 0] = first.ravel()
        self._index.write(index)
        self._grid = tables.grid
        # Two neighbouring levels are read for each Gaussian.
        pairs = first[:, 2:] - first[:, :-2]
        self._slices = pairs[[place.shape for place in tables.placements]].max(axis=1).sum()

    def defines(self) -> dict:
        return {}

    def bind(self, program) -> None:
        for unit, texture in zip((AZIMUTH_UNIT, XI_UNIT, O_UNIT), (self._azimuth, *self._textures), strict=True):
            texture.use(unit)
        self._index.bind(INDEX_UNIT)
        values = {
            "grid": float(self._grid),
            "inner": inner_share(self._grid),
            "tiling": tuple(self._tiling),
            "segments": self._segments,
        }
        for name, value in values.items():
            if name in program:
                program[name].value = value

    def passes(self) -> Iterator[dict]:
        """One pass, or as many as keep each below the iterations that every OpenGL runs; the first has the suns."""
        per_lobe = len(self._fabric.tangents) * (2 + self._segments // 2) + int(self._slices)
        lobes = max(1, MOST_ITERATIONS // per_lobe)
        for first in range(0, max(self._count, 1), lobes):
            later = {"sun_count": 0} if first else {}
            yield {"lobe_range": (first, min(first + lobes, self._count)), **later}

    def evaluations_per_pixel(self) -> int:
        """Theta nodes times Gaussians times tangents."""
        return (self._segments - 1) * self._count * len(self._fabric.tangents)

    def release(self) -> None:
        for texture in (*self._textures, self._azimuth):
            texture.release()
        self._index.release()


def _volume(ctx, texels: np.ndarray, kind: str) -> moderngl.Texture3D:
    """A 3D texture of texels [depth, height, width, 4], filtered linearly and clamped at its edges."""
    depth, height, width, _ = texels.shape
    texture = ctx.texture3d((width, height, depth), 4, texels.astype(kind).tobytes(), dtype=kind)
    texture.filter = moderngl.LINEAR, moderngl.LINEAR
    texture.repeat_x = texture.repeat_y = texture.repeat_z = False
    return texture
