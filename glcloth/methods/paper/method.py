"""Method `paper`: paper A literally, with T from SVD-compressed tables and theta segments (Mizutani et al. 2012)."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import moderngl
import numpy as np

from ...errors import InputError
from ...fabric import Fabric
from ...gpu.buffers import TextureBuffer
from ...gpu.layout import constant
from ...gpu.memo import Last
from ...light.lights import Lights
from ...twins.convolution import theta_end
from ..method import Method
from ..settings import Settings
from .precompute import Tables, inner_share
from .shapes import shapes_of
from .tables import azimuth_texels, check_parameters, slice_index, slices, tables_for, texel_type, tiled

DEEPEST = 2048  # slices of a 3D texture that every OpenGL 4.3 takes
NO_END = 1e3  # an end of theta_i behind all nodes
# Loop iterations of one invocation, below llvmpipe's silent end at 65,535.
MOST_ITERATIONS = 50_000


class Paper(Method):
    """Shades by T times I for each tangent and Gaussian.   [Miz 8-16]

    A change of the weave (tilts, areas, normalisation, width of shadowing) remakes the tables; colours, eta, k_d and
    the lobe widths are read as they are. Gaussians sharper than the last level (1500) use that level's T, which is W
    averaged over 2 degrees; their I is exact.
    """

    source = "inputs/methods/paper.glsl"

    def __init__(self, ctx: moderngl.Context):
        super().__init__(ctx)
        self._index = TextureBuffer(ctx, 16 * int(constant("MAX_TANGENTS")))
        self._azimuth = _volume(ctx, azimuth_texels(), "f4")
        self._weave: Last[str] = Last()
        self._tables: Last[dict[str, Any]] = Last()
        self._tangents = self._count = self._segments = self._slices = 0
        self._upright = False

    def prepare(self, fabric: Fabric, lights: Lights, settings: Settings, part: int | None = None) -> None:
        """Make and upload the tables when the weave or their parameters changed.

        Raises InputError for segments outside 2 to 64 and for grid or contribution out of range.
        """
        segments, grid, contribution = settings.segments, settings.grid, settings.contribution
        if not 2 <= segments <= 64:
            raise InputError(f"segments {segments}: expected 2 to 64 (the paper: 6)")
        check_parameters(grid, contribution)
        self._segments, self._count, self._tangents = segments, len(lights.gaussians), len(fabric.tangents)
        self.broad = np.zeros(self._count)
        # The tables know W but for its numerators: those, and `part` with them, are read from the fabric's records.
        self._upright = any(theta_end(t.tilt) < np.pi / 2 for t in fabric.tangents)
        weave = self._weave.get(lambda: repr(shapes_of(fabric)), fabric)
        self._tables.get(
            lambda: self._upload(tables_for(fabric, grid, contribution), fabric), weave, grid, contribution
        )

    def _upload(self, tables: Tables, fabric: Fabric) -> dict[str, Any]:
        kind = texel_type(tables)
        self._release_weights()
        (left, *tiling), (right, *_) = (tiled(slices(side), DEEPEST) for side in (tables.xi, tables.o))
        first = slice_index(tables)
        index = np.zeros((int(constant("MAX_TANGENTS")) + first.size, 4), "f4")
        for t, (place, tangent) in enumerate(zip(tables.placements, fabric.tangents, strict=True)):
            end = float(theta_end(tangent.tilt))
            index[t] = place.shape, place.theta, place.phi, end if end < np.pi / 2 else NO_END
        index[int(constant("MAX_TANGENTS")) :, 0] = first.ravel()
        self._index.write(index)
        # Two neighbouring levels are read for each Gaussian.
        pairs = first[:, 2:] - first[:, :-2]
        self._slices = int(pairs[[place.shape for place in tables.placements]].max(axis=1).sum())
        return {
            "weight_xi": _volume(self.ctx, left, kind),
            "weight_o": _volume(self.ctx, right, kind),
            "grid": float(tables.grid),
            "inner": inner_share(tables.grid),
            "tiling": tuple(tiling),
        }

    def woven_packing(self) -> tuple[int, int]:
        """In the order of the tangents."""
        return -(-self._tangents // 4), 4

    def defines(self) -> dict[str, Any]:
        """Whether there are upright tangents, whose domain ends early: an edit makes others only with new tables."""
        return {"UPRIGHT": 1} if self._upright else {}

    def inputs(self) -> dict[str, Any]:
        """What inputs/methods/paper.glsl declares, but for the range of a pass."""
        own = {"azimuth_table": self._azimuth, "weight_index": self._index, "segments": self._segments}
        return {**own, **(self._tables.value or {})}

    def passes(self) -> Iterator[dict[str, Any]]:
        """One pass, or as many as keep each below the iterations that every OpenGL runs; the first has the suns."""
        per_lobe = self._tangents * (2 + self._segments // 2) + self._slices
        lobes = max(1, MOST_ITERATIONS // per_lobe)
        for first in range(0, max(self._count, 1), lobes):
            later = {"sun_count": 0} if first else {}
            yield {"lobe_range": (first, min(first + lobes, self._count)), **later}

    def evaluations_per_pixel(self) -> int:
        """Theta nodes times Gaussians times tangents."""
        return (self._segments - 1) * self._count * self._tangents

    def release(self) -> None:
        """Free the GPU's memory."""
        self._release_weights()
        self._tables.forget()
        self._azimuth.release()
        self._index.release()

    def _release_weights(self) -> None:
        if (tables := self._tables.value) is not None:
            tables["weight_xi"].release()
            tables["weight_o"].release()


def _volume(ctx: moderngl.Context, texels: np.ndarray, kind: str) -> moderngl.Texture3D:
    """A 3D texture of texels [depth, height, width, 4], filtered linearly and clamped at its edges."""
    depth, height, width, _ = texels.shape
    texture = ctx.texture3d((width, height, depth), 4, texels.astype(kind).tobytes(), dtype=kind)
    texture.filter = moderngl.LINEAR, moderngl.LINEAR
    texture.repeat_x = texture.repeat_y = texture.repeat_z = False
    return texture
