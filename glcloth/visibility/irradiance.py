"""Irradiance of Gaussians over the cosine of their axis, as a table that inputs/visibility/irradiance_table.glsl reads."""

from __future__ import annotations

from typing import Any

import moderngl
import numpy as np

from ..gpu.buffers import TextureBuffer
from ..gpu.context_local import of_context
from ..gpu.memo import Last
from ..light.lights import Lights
from ..twins.lambert import gaussian_above, gaussian_irradiance

STEPS = 256  # over the cosine from -1 to 1: linear between them it errs by 1e-4 of a light's flux


class _Table:
    def __init__(self, ctx: moderngl.Context):
        self.buffer = TextureBuffer(ctx, 16, "rg32f")
        self.written: Last[None] = Last()


def irradiance_table(ctx: moderngl.Context, lights: Lights) -> dict[str, Any]:
    """The table for some lights by its name in GLSL; one for a context, written when the widths of the lights change."""
    table, sharpness = of_context(_Table, ctx), lights.gaussians.sharpness
    values = sharpness[:, None], np.linspace(-1.0, 1.0, STEPS + 1)

    def write() -> None:
        table.buffer.write(np.stack([gaussian_irradiance(*values), gaussian_above(*values)], -1).astype("f4"))

    table.written.get(write, sharpness.tobytes())
    return {"irradiance_table": table.buffer}
