"""Irradiance of Gaussians over the cosine of their axis, as a table that inputs/visibility/irradiance_table.glsl reads."""

from __future__ import annotations

from typing import Any

import moderngl
import numpy as np

from ..gpu.buffers import TextureBuffer
from ..gpu.context_local import of_context
from ..gpu.memo import Last
from ..light.lights import Lights
from ..twins.lambert import gaussian_irradiance

STEPS = 256  # over the cosine from -1 to 1: linear between them it errs by 1e-4 of a light's flux


class IrradianceTable:
    """The table of the last lights."""

    def __init__(self, ctx: moderngl.Context):
        self._table = TextureBuffer(ctx, 16, "r32f")
        self._written: Last[None] = Last()

    def inputs(self, lights: Lights) -> dict[str, Any]:
        """The table, written when the widths of the lights change."""
        self._written.get(lambda: self._write(lights), lights.gaussians.sharpness.tobytes())
        return {"irradiance_table": self._table}

    def _write(self, lights: Lights) -> None:
        cos = np.linspace(-1.0, 1.0, STEPS + 1)
        self._table.write(gaussian_irradiance(lights.gaussians.sharpness[:, None], cos).astype("f4"))


def irradiance_table(ctx: moderngl.Context, lights: Lights) -> dict[str, Any]:
    """The table for some lights, by its name in GLSL."""
    return of_context(IrradianceTable, ctx).inputs(lights)
