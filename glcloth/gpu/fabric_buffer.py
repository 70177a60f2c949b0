"""The fabric of a draw as a texture buffer, laid out as glsl/inputs/picture/fabric.glsl reads it."""

from __future__ import annotations

import numpy as np

from ..fabric import Fabric
from . import shader
from .buffers import TextureBuffer
from .layout import constant, struct

FABRIC_UNIT = 0


def fabric_records(fabric: Fabric) -> bytes:
    """Two Yarns, then the Tangents in the order of `fabric.tangents` (those of yarn 0 first)."""
    yarns = np.zeros(2, struct("Yarn"))
    for record, yarn in zip(yarns, fabric.yarn, strict=True):
        record["A"] = yarn.albedo
        record["eta"], record["k_d"], record["a"] = yarn.eta, yarn.k_d, yarn.area
        record["gamma_s"], record["gamma_v"] = np.radians([yarn.gamma_s_deg, yarn.gamma_v_deg])
    tangents = np.zeros(len(fabric.tangents), struct("Tangent"))
    tilt = np.array([t.tilt for t in fabric.tangents])
    tangents["cos_tilt"], tangents["sin_tilt"] = np.cos(tilt), np.sin(tilt)
    tangents["weight"], tangents["share"] = fabric.weights.T
    return yarns.tobytes() + tangents.tobytes()


class FabricBuffer:
    """Uploads a fabric when it changes, and binds it for any program that includes inputs/picture/fabric.glsl."""

    def __init__(self, ctx):
        self._data = TextureBuffer(ctx, 16 * (4 + int(constant("MAX_TANGENTS"))))
        self.fabric: Fabric | None = None
        self._uniforms: dict[str, object] = {}

    def prepare(self, fabric: Fabric) -> None:
        """Upload the fabric if it is another one than last time."""
        if fabric is not self.fabric:
            self._data.write(fabric_records(fabric))
            self.fabric = fabric
            counts = tuple(sum(t.yarn == j for t in fabric.tangents) for j in (0, 1))
            self._uniforms = {"tangent_count": counts, "sigma_mask": fabric.sigma, "gap": fabric.gap}

    def bind(self, program) -> None:
        """Bind the buffer and set the uniforms that inputs/picture/fabric.glsl declares."""
        self._data.bind(FABRIC_UNIT)
        shader.set_uniforms(program, **self._uniforms)

    def release(self) -> None:
        """Free the GPU's memory."""
        self._data.release()
