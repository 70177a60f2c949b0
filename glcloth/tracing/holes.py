"""Holes of a woven cloth that is traced: where they are, as far as pixels are fine enough to tell.   [own]

Far away the holes of a weave are a share of the light that every place lets through (woven/sheet.glsl, T_sheet). Near by the
same light goes through the holes themselves (T_sheet_at), whose mean over a repeat is that share.
"""

from __future__ import annotations

from typing import Any

import moderngl
import numpy as np

from ..fabric import Fabric
from ..gpu.memo import Last
from ..methods.weave_maps import fabric_maps, far_footprint
from ..weave.maps import mip_levels
from .shot import Shot


class Holes:
    """The map of holes that inputs/tracing/holes.glsl reads, on one context."""

    def __init__(self, ctx: moderngl.Context):
        self.ctx = ctx
        self._made: Last[dict[str, Any]] = Last()
        self._texture: moderngl.Texture | None = None

    def inputs(self, shot: Shot) -> dict[str, Any]:
        """What that file reads; nothing where no pixel shows a hole, or rays are drawn at random."""
        fabric, grid, camera = shot.fabric, shot.grid, shot.camera
        if grid is None or fabric.weave is None or shot.settings.spread:
            return {}
        constant, by_distance = pixel_size(shot)
        eye = np.asarray(camera.eye)
        nearest = np.linalg.norm(np.maximum(np.maximum(np.subtract(grid.low, eye), eye - np.array(grid.high)), 0.0))
        if constant + by_distance * nearest >= far_footprint(fabric):
            return {}
        made = self._made.get(lambda: self._make(fabric), fabric)
        if not made["hole_mean"]:
            return {}
        return {
            **made,
            "hole_grid": (grid.first, grid.quads),
            "hole_pieces": (grid.count or 1 << 30, grid.pieces),
            "quad_size": grid.size,
            "seen_from": tuple(map(float, camera.eye)),
            "pixel_size": (constant, by_distance),
            "shines_from": shot.lighting.lamp.position,
        }

    def _make(self, fabric: Fabric) -> dict[str, Any]:
        maps = fabric_maps(fabric)
        height, width = maps.hole.shape
        if self._texture is not None:
            self._texture.release()
        self._texture = texture = self.ctx.texture((width, height), 1, dtype="f4")
        texture.build_mipmaps()  # makes room
        texture.filter = moderngl.LINEAR_MIPMAP_LINEAR, moderngl.LINEAR
        for level, means in enumerate(mip_levels(maps.hole)):
            texture.write(means.astype("f4"), level=level)
        repeats = 1.0 / maps.size[0], 1.0 / maps.size[1]
        return {"hole_map": texture, "hole_mean": float(maps.hole.mean()), "hole_repeats": repeats}

    def release(self) -> None:
        """Free the GPU's memory."""
        if self._texture is not None:
            self._texture.release()
            self._texture = None
            self._made.forget()


def pixel_size(shot: Shot) -> tuple[float, float]:
    """Metres that a pixel in the middle of the picture covers: anywhere (rays in parallel), and for each metre away."""
    if shot.camera.ortho is not None:
        return shot.camera.ortho / shot.size[1], 0.0
    return 0.0, float(2.0 * np.tan(0.5 * np.radians(shot.camera.fov_deg)) / shot.size[1])
