"""The environment behind a picture."""

from __future__ import annotations

from typing import Any

import moderngl
import numpy as np

from ..geometry.camera import lens_samples, sample_offsets
from ..gpu.environment_map import EnvironmentMap
from ..gpu.programs import programs
from ..gpu.screen import draw_screen
from ..light.environment import rotation_y
from .frame import Frame


class Background:
    """Fills the pixels that the surfaces leave uncovered."""

    def __init__(self, ctx: moderngl.Context):
        self.ctx = ctx
        self._map = EnvironmentMap(ctx)

    def draw(self, frame: Frame, target: moderngl.Framebuffer) -> None:
        """Draw the environment of a frame behind its picture, seen through the centres of the pixels' last sample, or through
        a lens by all samples."""
        offsets = sample_offsets(frame.scene.spp)
        blurred = frame.camera.aperture > 0.0
        cameras = lens_samples(frame.camera, len(offsets)) if blurred else [frame.camera]
        for camera, offset in zip(cameras, offsets if blurred else offsets[-1:], strict=True):
            draw_screen(
                programs(self.ctx).screen("passes/picture/background.frag"),
                target,
                blend="behind",
                **self.inputs(frame, camera.ray_from_pixel(target.size, offset)),
                weight=1.0 / len(cameras),
            )

    def inputs(self, frame: Frame, ray_from_pixel: np.ndarray) -> dict[str, Any]:
        """The environment of a frame for passes that see it along rays, by its names in GLSL."""
        return {
            "environment_map": self._map.texture(frame.environment),
            "environment_from_world": rotation_y(-frame.scene.env_rotate),
            "ray_from_pixel": ray_from_pixel,
        }
