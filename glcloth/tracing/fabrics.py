"""Several fabrics in one traced scene, each that of a run of triangles: what inputs/tracing/fabrics.glsl reads.   [own]

One fabric alone is in uniforms, as ever: the text of its passes does not know of others.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import moderngl
import numpy as np

from ..fabric import Fabric, Transmission
from ..gpu.buffers import TextureBuffer
from ..gpu.layout import constant
from ..gpu.memo import Last
from ..gpu.scene_buffers import fabric_records
from .energy import mean_albedo, reflection_limit
from .shot import MOST_FABRICS, Shot

NOWHERE = 0x7FFFFFFF  # a triangle behind all


def straight_share(transmission: Transmission, indirect: bool) -> float:
    """Of the yarns' light that passes, what goes on straight to the lamp: half of it; with light from all around all but what
    is scattered."""
    return 1.0 - 0.5 * transmission.diffuse if indirect else 0.5


def fabric_defines(inputs: Mapping[str, Any]) -> dict[str, Any]:
    """The define of passes that meet cloth of the `inputs` of a tracer."""
    return {"FABRICS": inputs["fabric_count"]} if "fabric_count" in inputs else {}


class Fabrics:
    """The fabrics of a scene that has several, on one context."""

    def __init__(self, ctx: moderngl.Context):
        self._rows, self._records = TextureBuffer(ctx, 64), TextureBuffer(ctx, 64)
        self._uploaded: Last[None] = Last()

    def inputs(self, shot: Shot) -> dict[str, Any]:
        """What takes the place of a single fabric's inputs; nothing for one alone."""
        if not shot.others:
            return {}
        indirect = shot.indirect is not None
        self._uploaded.get(lambda: self._upload(shot.fabrics, indirect), indirect, *shot.fabrics)
        begins = [first for first, _ in shot.others]
        return {
            "fabric_count": len(shot.fabrics),
            "fabric_rows": self._rows,
            "fabric_data": self._records,
            "fabric_stride": 4 + int(constant("MAX_TANGENTS")),
            "fabric_from": (begins + [NOWHERE] * MOST_FABRICS)[:MOST_FABRICS],
        }

    def _upload(self, fabrics: tuple[Fabric, ...], indirect: bool) -> None:
        rows, records = np.zeros((len(fabrics), 5, 4), "f4"), b""
        stride = 16 * (4 + int(constant("MAX_TANGENTS")))
        for row, fabric in zip(rows, fabrics, strict=True):
            t, limit = fabric.transmission, reflection_limit(fabric)
            assert t is not None, "a Shot has looked"
            row[0], row[1] = (t.rho, t.k_a, t.k_t, t.diffuse), (*t.tau, straight_share(t, indirect))
            row[2] = t.roughness, t.eta_1, t.eta_2, t.roughness_p
            row[3] = *(mean_albedo(fabric) * limit), limit
            row[4] = *(sum(one.yarn == j for one in fabric.tangents) for j in (0, 1)), fabric.sigma, fabric.gap
            records += fabric_records(fabric).ljust(stride, b"\0")
        self._rows.write(rows)
        self._records.write(records)

    def release(self) -> None:
        """Free the GPU's memory."""
        self._rows.release()
        self._records.release()
