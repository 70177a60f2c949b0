"""The rasterised picture of the same curtain, for comparison: sorted layers, blended, without shadows.   [Mat figure 2]"""

from __future__ import annotations

import moderngl
import numpy as np

from ..geometry.camera import Camera
from ..gpu import shader
from ..gpu.buffers import TextureBuffer

ORDER_UNIT = 15


class LayersPicture:
    """Draws the triangles of a Tracer with the rasteriser; materials, fabric and lights are the tracer's."""

    def __init__(self, ctx: moderngl.Context):
        self.ctx = ctx
        self._order = TextureBuffer(ctx, 64, "r32ui")
        self.program = shader.program(ctx, "passes/tracing/layers.vert", "passes/tracing/layers.frag")
        self._array = ctx.vertex_array(self.program, [])

    def draw(
        self, positions: np.ndarray, cloth: np.ndarray, camera: Camera, size: tuple[int, int], background
    ) -> np.ndarray:
        """Draw once the program's uniforms and buffers are bound.

        Parameters
        ----------
        positions : [T, 3, 3], the triangles as they are on the GPU; cloth : [T] bool, the transparent ones
        background : radiance [3] behind everything

        Returns float32 [H, W, 3], linear, top row first.
        """
        ctx = self.ctx
        depth = (positions.mean(1) - camera.eye) @ camera.axes[2]
        solid = np.flatnonzero(~cloth)
        layers = np.flatnonzero(cloth)
        layers = layers[np.argsort(-depth[layers], kind="stable")]
        self._order.write(np.concatenate([solid, layers]).astype(np.uint32))
        near, far = camera.depth_range(positions.min((0, 1)), positions.max((0, 1)))
        self.program["clip_from_world"].write(camera.clip_from_world(size, near, far).T.astype("f4").tobytes())
        shader.set_uniforms(self.program, eye=camera.eye)
        self._order.bind(ORDER_UNIT)
        color = ctx.texture(size, 4, dtype="f4")
        buffer = ctx.depth_renderbuffer(size)
        target = ctx.framebuffer([color], buffer)
        try:
            target.use()
            ctx.viewport = (0, 0, *size)
            target.clear(*map(float, background), 1.0)
            ctx.enable(moderngl.DEPTH_TEST)
            if len(solid):
                self._array.render(moderngl.TRIANGLES, vertices=3 * len(solid))
            if len(layers):
                # From back to front; the layers hide nothing, so they write no depth.
                target.depth_mask = False
                ctx.enable(moderngl.BLEND)
                ctx.blend_func = moderngl.ONE, moderngl.ONE_MINUS_SRC_ALPHA
                self._array.render(moderngl.TRIANGLES, vertices=3 * len(layers), first=3 * len(solid))
            picture = np.frombuffer(color.read(), np.float32).reshape(size[1], size[0], 4)
            return picture[::-1, :, :3].copy()
        finally:
            target.depth_mask = True
            ctx.disable(moderngl.BLEND)
            ctx.disable(moderngl.DEPTH_TEST)
            ctx.blend_func = moderngl.SRC_ALPHA, moderngl.ONE_MINUS_SRC_ALPHA
            # moderngl binds the last framebuffer back after making a new one; it must not be a deleted one.
            ctx.detect_framebuffer(0).use()
            for thing in (target, buffer, color):
                thing.release()

    def release(self) -> None:
        """Free the GPU's memory."""
        for thing in (self._array, self.program, self._order):
            thing.release()
