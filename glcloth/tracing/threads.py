"""Threads of a woven cloth that is traced, and the holes between them, as far as pixels are fine enough to tell.   [own]

Far away the holes of a weave are a share of the light that every place lets through (woven/sheet.glsl, T_sheet), and its
tangents have the same weights everywhere. Near by the same light goes through the holes themselves (T_sheet_at), and the sum
over tangents has the weights of the place. The mean over a repeat of both is the far cloth.
"""

from __future__ import annotations

from typing import Any

import moderngl
import numpy as np

from ..fabric import Fabric
from ..gpu.memo import Last
from ..methods.weave_maps import WeaveMaps, fabric_maps, far_footprint, packed
from ..weave.maps import mip_levels
from .shot import Shot

LANES = 4  # tangents in a vec4, in their order
INCLUDE = {"inputs/methods/threads.glsl": "inputs/tracing/threads.glsl"}


class Threads:
    """The maps that inputs/tracing/holes.glsl and threads.glsl read, on one context."""

    def __init__(self, ctx: moderngl.Context):
        self.ctx = ctx
        self._made: Last[dict[str, Any]] = Last()
        self._texture: moderngl.Texture | None = None
        self._maps: WeaveMaps | None = None

    def inputs(self, shot: Shot) -> dict[str, Any]:
        """What those files read; nothing where no pixel shows a thread, or rays are drawn at random."""
        fabric, grid, camera = shot.fabric, shot.grid, shot.camera
        if grid is None or fabric.weave is None or shot.settings.spread:
            return {}
        constant, by_distance = pixel_size(shot)
        eye = np.asarray(camera.eye)
        nearest = np.linalg.norm(np.maximum(np.maximum(np.subtract(grid.low, eye), eye - np.array(grid.high)), 0.0))
        far = far_footprint(fabric)
        if constant + by_distance * nearest >= far:
            return {}
        return {
            **self._made.get(lambda: self._make(fabric), fabric),
            "hole_grid": (grid.first, grid.quads),
            "hole_pieces": (grid.count or 1 << 30, grid.pieces),
            "quad_size": grid.size,
            "seen_from": tuple(map(float, camera.eye)),
            "pixel_size": (constant, by_distance),
            "shines_from": shot.lighting.lamp.position,
            "far_footprint": far,
        }

    def _make(self, fabric: Fabric) -> dict[str, Any]:
        # Rays meet a sheet without thickness: yarns that hide each other from the side are no part of it.
        assert fabric.weave is not None
        flat = fabric.changed(weave=fabric.weave.changed(relief=0.0))
        maps, groups = fabric_maps(flat), tangent_groups(fabric)
        height, width = maps.hole.shape
        if self._texture is not None:
            self._texture.release()
        self._texture = texture = self.ctx.texture((width, height), 1, dtype="f4")
        texture.build_mipmaps()  # makes room
        texture.filter = moderngl.LINEAR_MIPMAP_LINEAR, moderngl.LINEAR
        for level, means in enumerate(mip_levels(maps.hole)):
            texture.write(means.astype("f4"), level=level)
        self._maps = self._maps or WeaveMaps(self.ctx)
        shares = flat.weights[:, 1] / flat.weights[:, 1].sum()
        return {
            **self._maps.inputs(flat, groups, LANES),
            "hole_map": texture,
            "hole_mean": float(maps.hole.mean()),
            "hole_repeats": (1.0 / maps.size[0], 1.0 / maps.size[1]),
            "tangent_shares": packed(shares, groups, LANES),
            "tangent_groups": groups,
        }

    def release(self) -> None:
        """Free the GPU's memory."""
        if self._texture is not None:
            self._texture.release()
            self._texture = None
            self._made.forget()
        if self._maps is not None:
            self._maps.release()
            self._maps = None


def tangent_groups(fabric: Fabric) -> int:
    """How many vec4s hold the tangents of a fabric."""
    return -(-len(fabric.tangents) // LANES)


def pixel_size(shot: Shot) -> tuple[float, float]:
    """Metres that a pixel in the middle of the picture covers: anywhere (rays in parallel), and for each metre away."""
    if shot.camera.ortho is not None:
        return shot.camera.ortho / shot.size[1], 0.0
    return 0.0, float(2.0 * np.tan(0.5 * np.radians(shot.camera.fov_deg)) / shot.size[1])
