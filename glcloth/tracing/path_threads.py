"""Threads of woven cloth in pictures by paths: maps of inputs/methods/weave.glsl, where a path from the eye meets cloth.   [own]

A program has the maps of one fabric. Where several fabrics show threads, each has a dispatch of its own for the same samples,
and a sample belongs to that of the first such fabric that the eye meets; the others leave it after that first ray.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import moderngl
import numpy as np

from ..fabric import Fabric
from ..geometry.camera import Camera
from ..gpu.buffers import TextureBuffer
from ..methods.weave_maps import WeaveMaps, far_footprint

LANES = 4  # tangents in a vec4, in their order
# Samples lie all over a pixel, which averages them; if each had the pixel's whole size threads would be blurred twice. With
# half its side means stay within .7 % of the far cloth to 70 degrees; with a quarter what yarns hide (methods/relief.py) errs
# by 1 %.
SAMPLE_SIDE = 0.5
INCLUDE = {"inputs/picture/pixel_uv.glsl": "inputs/tracing/path_uv.glsl"}
NONE = -1.0


class ThreadDispatch(NamedTuple):
    """One fabric's part of the samples: constants of its program, and what that reads."""

    defines: dict[str, Any]
    inputs: dict[str, Any]


class PathThreads:
    """The maps of the fabrics of a world, on one context."""

    def __init__(self, ctx: moderngl.Context):
        self.ctx = ctx
        self._maps: list[WeaveMaps] = []
        self._rows = TextureBuffer(ctx, 16)

    def dispatches(
        self, fabrics: Sequence[Fabric], units: Sequence[float | None], camera: Camera, size: tuple[int, int]
    ) -> list[ThreadDispatch]:
        """What shows the threads of a picture; none where none shows.

        fabrics : all that are worn. units : metres in a UV unit of each one's cloth; None: no pixel shows its threads
        """
        shown: list[Fabric] = []
        rows = np.zeros((len(fabrics), 4), "f4")
        for row, fabric, unit in zip(rows, fabrics, units, strict=True):
            if unit is None:
                row[0] = NONE
                continue
            if not any(fabric is other for other in shown):
                shown.append(fabric)
            row[:2] = [other is fabric for other in shown].index(True), unit
        if not shown:
            return []
        self._rows.write(rows)
        while len(self._maps) < len(shown):
            self._maps.append(WeaveMaps(self.ctx))
        step = SAMPLE_SIDE * camera.step_from_pixel(size)
        place = {"thread_rows": self._rows, "step_from_pixel": step, "in_parallel": camera.ortho is not None}
        return [
            ThreadDispatch(
                _defines(fabric), {**maps.inputs(fabric, _groups(fabric), LANES), **place, **_own(fabric, k)}
            )
            for k, (fabric, maps) in enumerate(zip(shown, self._maps, strict=False))
        ]

    def release(self) -> None:
        """Free the GPU's memory."""
        for maps in self._maps:
            maps.release()
        self._rows.release()


def _groups(fabric: Fabric) -> int:
    """How many vec4s hold the tangents of a fabric."""
    return -(-len(fabric.tangents) // LANES)


def _own(fabric: Fabric, number: int) -> dict[str, Any]:
    return {"dispatch": number, "far_footprint": SAMPLE_SIDE * far_footprint(fabric)}


def _defines(fabric: Fabric) -> dict[str, Any]:
    """Constants of the program for a fabric's threads, as of those of other methods."""
    groups, weave = _groups(fabric), fabric.weave
    each = " ".join(f"F({g});" for g in range(groups))
    relief = {"RELIEF": 1} if weave is not None and weave.relief else {}
    plain = {"ONE_COLOR": 1} if weave is not None and weave.thread_colors is None else {}
    return {"WEAVE": 1, "GROUPS": groups, "LANE_COUNT": LANES, "EACH_GROUP(F)": each, **relief, **plain}
