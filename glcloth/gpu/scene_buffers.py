"""The fabric and the lights of a draw as texture buffers, as glsl/inputs/picture reads them."""

from __future__ import annotations

import numpy as np

from ..errors import InputError
from ..fabric import Fabric
from ..light.lights import Lights
from .buffers import TextureBuffer
from .fabric_buffer import FABRIC_UNIT, fabric_records
from .layout import constant, struct

LIGHT_UNIT = 1


def light_records(lights: Lights) -> bytes:
    """MAX_LOBES Gaussians (the unused ones zero), then the Suns."""
    lobes, suns = int(constant("MAX_LOBES")), int(constant("MAX_SUNS"))
    if len(lights.gaussians) > lobes:
        raise InputError(f"{len(lights.gaussians)} spherical Gaussians, expected at most {lobes}; fit fewer lobes")
    if len(lights.suns) > suns:
        raise InputError(f"{len(lights.suns)} suns, expected at most {suns}; merge the weakest into the Gaussians")
    gaussians = np.zeros(lobes, struct("Gaussian"))
    used = gaussians[: len(lights.gaussians)]
    used["xi"], used["sharpness"], used["L"] = (
        lights.gaussians.axis,
        lights.gaussians.sharpness,
        lights.gaussians.amplitude,
    )
    records = np.zeros(suns, struct("Sun"))
    records["omega"][: len(lights.suns)] = lights.suns.direction
    records["E"][: len(lights.suns)] = lights.suns.irradiance
    return gaussians.tobytes() + records.tobytes()


class SceneBuffers:
    """Uploads fabric and lights when they change, and binds them for any program that reads them."""

    def __init__(self, ctx):
        self._fabric_data = TextureBuffer(ctx, 16 * (4 + int(constant("MAX_TANGENTS"))))
        self._light_data = TextureBuffer(ctx, 32 * (int(constant("MAX_LOBES")) + int(constant("MAX_SUNS"))))
        self.fabric: Fabric | None = None
        self.lights: Lights | None = None

    def prepare(self, fabric: Fabric, lights: Lights) -> None:
        """Upload what differs from the last call. Raises InputError for too many lobes or suns."""
        if fabric is not self.fabric:
            self._fabric_data.write(fabric_records(fabric))
            self.fabric = fabric
        if lights is not self.lights:
            self._light_data.write(light_records(lights))
            self.lights = lights

    def bind(self, program) -> None:
        """Bind the buffers and set the uniforms that inputs/picture/fabric.glsl and inputs/picture/lights.glsl declare."""
        self._fabric_data.bind(FABRIC_UNIT)
        self._light_data.bind(LIGHT_UNIT)
        for name, value in self.inputs().items():
            if name in program and not isinstance(value, TextureBuffer):
                program[name].value = value

    def inputs(self) -> dict:
        """What inputs/picture/fabric.glsl and inputs/picture/lights.glsl read."""
        counts = [sum(t.yarn == j for t in self.fabric.tangents) for j in (0, 1)]
        return {
            "fabric_data": self._fabric_data,
            "light_data": self._light_data,
            "tangent_count": tuple(counts),
            "sigma_mask": self.fabric.sigma,
            "gap": self.fabric.gap,
            "gaussian_count": len(self.lights.gaussians),
            "sun_count": len(self.lights.suns),
        }

    def release(self) -> None:
        self._fabric_data.release()
        self._light_data.release()
