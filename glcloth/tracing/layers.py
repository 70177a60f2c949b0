"""The rasterised picture of the same scene, for comparison: sorted layers, blended, without shadows.   [Mat figure 2]"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import moderngl
import numpy as np

from ..geometry.camera import Camera
from ..gpu.buffers import TextureBuffer
from ..gpu.programs import programs
from .canvas import Canvas
from .fabrics import fabric_defines


def draw_layers(
    ctx: moderngl.Context,
    positions: np.ndarray,
    cloth: np.ndarray,
    camera: Camera,
    size: tuple[int, int],
    background: Sequence[float],
    inputs: Mapping[str, Any],
) -> np.ndarray:
    """Draw triangles with the rasteriser.

    Parameters
    ----------
    positions : [T, 3, 3], the triangles as they are on the GPU; cloth : [T] bool, the transparent ones
    background : radiance [3] behind everything
    inputs : of passes/tracing/layers.frag: surfaces, fabric and light

    Returns float32 [H, W, 3], linear, top row first.
    """
    depth = (positions.mean(1) - camera.eye) @ camera.axes[2]
    solid, layers = np.flatnonzero(~cloth), np.flatnonzero(cloth)
    layers = layers[np.argsort(-depth[layers], kind="stable")]
    order = TextureBuffer(ctx, np.concatenate([solid, layers]).astype(np.uint32), "r32ui")
    near, far = camera.depth_range(positions.min((0, 1)), positions.max((0, 1)))
    canvas = Canvas(ctx, size)
    try:
        canvas.clear(background)
        program = programs(ctx).draw("passes/tracing/layers.vert", "passes/tracing/layers.frag", fabric_defines(inputs))
        clip_from_world = camera.clip_from_world(size, near, far)
        program.bind(inputs, order=order, clip_from_world=clip_from_world, viewpoint=camera.viewpoint)
        if len(solid):
            canvas.draw(program, moderngl.TRIANGLES, 3 * len(solid))
        if len(layers):
            # From back to front; the layers hide nothing.
            canvas.draw(program, moderngl.TRIANGLES, 3 * len(layers), first=3 * len(solid), blend=True)
        return canvas.pixels()
    finally:
        canvas.release()
        order.release()
