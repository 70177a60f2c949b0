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
from ..methods.weave_maps import (
    color_layers,
    fabric_maps,
    far_footprint,
    packed,
    texture_array,
    thread_layers,
)  # fmt: skip
from ..weave.maps import mip_levels
from .shot import HangingGrid, Shot
from .threads_of_several import ThreadsOfSeveral

LANES = 4  # tangents in a vec4, in their order
INCLUDE = {"inputs/methods/threads.glsl": "inputs/tracing/threads.glsl"}


class Threads:
    """The maps that inputs/tracing/holes.glsl and threads.glsl read, on one context."""

    def __init__(self, ctx: moderngl.Context):
        self.ctx = ctx
        self._made: Last[dict[str, Any]] = Last()
        self._texture: moderngl.Texture | None = None
        self._maps: list[moderngl.TextureArray] = []
        self._several: ThreadsOfSeveral | None = None

    def inputs(self, shot: Shot) -> dict[str, Any]:
        """What those files read; nothing where no pixel shows a thread, or rays are drawn at random."""
        if shot.settings.spread or not any(
            shows_threads(shot, fabric, grid) for fabric, grid in zip(shot.fabrics, shot.grids, strict=True)
        ):
            return {}
        shared = {
            "seen_from": tuple(map(float, shot.camera.eye)),
            "pixel_size": pixel_size(shot),
            "shines_from": shot.lighting.lamp.position,
        }
        if shot.others:
            self._several = self._several or ThreadsOfSeveral(self.ctx)
            return {**self._several.inputs(shot.fabrics, shot.grids, LANES), **shared}
        fabric, grid = shot.fabric, shot.grid
        assert grid is not None
        return {
            **self._made.get(lambda: self._make(fabric), fabric),
            "hole_grid": (grid.first, grid.quads, grid.count or 1 << 30),
            "quad_size": grid.size,
            **shared,
            "far_footprint": far_footprint(fabric),
        }

    def _make(self, fabric: Fabric) -> dict[str, Any]:
        # Rays meet a sheet without thickness: yarns that hide each other from the side are no part of it.
        assert fabric.weave is not None
        flat = fabric.changed(weave=fabric.weave.changed(relief=0.0))
        maps, groups = fabric_maps(flat), tangent_groups(fabric)
        height, width = maps.hole.shape
        self._release_maps()
        self._texture = texture = self.ctx.texture((width, height), 1, dtype="f4")
        texture.build_mipmaps()  # makes room
        texture.filter = moderngl.LINEAR_MIPMAP_LINEAR, moderngl.LINEAR
        for level, means in enumerate(mip_levels(maps.hole)):
            texture.write(means.astype("f4"), level=level)
        shares = flat.weights[:, 1] / flat.weights[:, 1].sum()
        colors, size, colored = color_layers(flat, maps)
        self._maps = [texture_array(self.ctx, layers) for layers in (thread_layers(flat, maps, groups, LANES), colors)]
        return {
            "weave_map": self._maps[0],
            "weave_repeats": (1.0 / maps.size[0], 1.0 / maps.size[1]),
            "color_map": self._maps[1],
            "colored": colored,
            "color_repeats": (1.0 / size[0], 1.0 / size[1]),
            "weave_A": np.array([yarn.albedo for yarn in flat.yarn], "f4"),
            "hole_map": texture,
            "hole_mean": float(maps.hole.mean()),
            "hole_repeats": (1.0 / maps.size[0], 1.0 / maps.size[1]),
            "tangent_shares": packed(shares, groups, LANES),
            "tangent_groups": groups,
        }

    def _release_maps(self) -> None:
        if self._texture is not None:
            self._texture.release()
        for maps in self._maps:
            maps.release()
        self._texture, self._maps = None, []

    def release(self) -> None:
        """Free the GPU's memory."""
        if self._texture is not None:
            self._made.forget()
        self._release_maps()
        if self._several is not None:
            self._several.release()
            self._several = None


def shows_threads(shot: Shot, fabric: Fabric, grid: HangingGrid | None) -> bool:
    """Whether pixels may be fine enough for the threads of a fabric whose cloth is a grid."""
    if grid is None or fabric.weave is None:
        return False
    constant, by_distance = pixel_size(shot)
    eye = np.asarray(shot.camera.eye)
    nearest = np.linalg.norm(np.maximum(np.maximum(np.subtract(grid.low, eye), eye - np.array(grid.high)), 0.0))
    return bool(constant + by_distance * nearest < far_footprint(fabric))


def tangent_groups(fabric: Fabric) -> int:
    """How many vec4s hold the tangents of a fabric."""
    return -(-len(fabric.tangents) // LANES)


def pixel_size(shot: Shot) -> tuple[float, float]:
    """Metres that a pixel in the middle of the picture covers: anywhere (rays in parallel), and for each metre away."""
    if shot.camera.ortho is not None:
        return shot.camera.ortho / shot.size[1], 0.0
    return 0.0, float(2.0 * np.tan(0.5 * np.radians(shot.camera.fov_deg)) / shot.size[1])
