"""The fabric and the lights of a draw as texture buffers, as glsl/inputs/picture reads them."""

from __future__ import annotations

from typing import Any

import moderngl
import numpy as np

from ..errors import InputError
from ..fabric import Fabric
from ..light.lights import Lights
from .buffers import TextureBuffer
from .layout import constant, struct
from .memo import Last


def fabric_records(fabric: Fabric, part: int | None = None) -> bytes:
    """Two Yarns, then the Tangents in the order of `fabric.tangents` (yarn 0 first); `part` as in SceneBuffers."""
    yarns = np.zeros(2, struct("Yarn"))
    for record, yarn in zip(yarns, fabric.yarn, strict=True):
        record["A"] = yarn.albedo
        record["eta"], record["k_d"], record["a"] = yarn.eta, yarn.k_d, yarn.area
        record["gamma_s"], record["gamma_v"] = np.radians([yarn.gamma_s_deg, yarn.gamma_v_deg])
    tangents = np.zeros(len(fabric.tangents), struct("Tangent"))
    tilt = np.array([t.tilt for t in fabric.tangents])
    tangents["cos_tilt"], tangents["sin_tilt"] = np.cos(tilt), np.sin(tilt)
    tangents["weight"], tangents["share"] = fabric.numerators(part), fabric.weights[:, 1]
    return yarns.tobytes() + tangents.tobytes()


def light_records(lights: Lights) -> bytes:
    """MAX_LOBES Gaussians (the unused ones zero), then the Suns. Raises InputError for too many of either."""
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
    records["sin_radius"][: len(lights.suns)] = np.sin(lights.suns.radius)
    records["E"][: len(lights.suns)] = lights.suns.irradiance
    return gaussians.tobytes() + records.tobytes()


class SceneBuffers:
    """Uploads a fabric and lights when they change, for programs with inputs/picture/fabric.glsl and lights.glsl."""

    def __init__(self, ctx: moderngl.Context):
        self._fabric_data = TextureBuffer(ctx, 16 * (4 + int(constant("MAX_TANGENTS"))))
        self._light_data = TextureBuffer(ctx, 32 * (int(constant("MAX_LOBES")) + int(constant("MAX_SUNS"))))
        self._fabric: Last[dict[str, Any]] = Last()
        self._lights: Last[dict[str, Any]] = Last()

    def prepare(self, fabric: Fabric, lights: Lights | None = None, part: int | None = None) -> None:
        """Upload what differs from the last call. Raises InputError for too many lobes or suns.

        Parameters
        ----------
        lights : None: the last ones stay
        part : number of a tangent: of the sum over tangents only its term is left
        """
        self._fabric.get(lambda: self._upload_fabric(fabric, part), fabric, part)
        if lights is not None:
            self._lights.get(lambda: self._upload_lights(lights), lights)

    def _upload_fabric(self, fabric: Fabric, part: int | None) -> dict[str, Any]:
        self._fabric_data.write(fabric_records(fabric, part))
        counts = tuple(sum(t.yarn == j for t in fabric.tangents) for j in (0, 1))
        values = {"tangent_count": counts, "sigma_mask": fabric.sigma, "gap": fabric.gap}
        return {"fabric_data": self._fabric_data, **values}

    def _upload_lights(self, lights: Lights) -> dict[str, Any]:
        self._light_data.write(light_records(lights))
        counts = {"gaussian_count": len(lights.gaussians), "sun_count": len(lights.suns)}
        return {"light_data": self._light_data, **counts}

    @property
    def fabric(self) -> Fabric | None:
        """The fabric that is on the GPU."""
        return self._fabric.key[0] if self._fabric.key else None

    def inputs(self) -> dict[str, Any]:
        """The inputs of inputs/picture/fabric.glsl and, where there are lights, of inputs/picture/lights.glsl."""
        return {**(self._fabric.value or {}), **(self._lights.value or {})}

    def release(self) -> None:
        """Free the GPU's memory."""
        self._fabric_data.release()
        self._light_data.release()
