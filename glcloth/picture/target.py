"""The picture of one size on the GPU, and the G-buffer of each surface that is shaded into it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import moderngl
import numpy as np

from ..errors import InputError
from ..geometry.camera import Camera
from ..gpu.gbuffer import DepthOrder, Drawn, GBuffer
from ..visibility.pixels import PixelView
from .surface import Surface

LIGHT_PARTS = ("bounce", "transmission")
KEPT_SIZES = 3  # pictures that stay when the size changes, so that a window can change between two


class Part(NamedTuple):
    """One surface on a target: its frames and depth, and how far these pixels see the lights."""

    buffer: GBuffer
    view: PixelView


class Target:
    """A colour texture, and a part for each surface; with `parted`, more textures for parts of the light."""

    def __init__(self, ctx: moderngl.Context, size: tuple[int, int], parted: bool = False):
        self.ctx, self.size = ctx, size
        self.color, *light = (ctx.texture(size, 4, dtype="f4") for _ in range(1 + len(LIGHT_PARTS) * parted))
        self.light = tuple(light)  # LIGHT_PARTS, as inputs/picture/parts.glsl has them
        for texture in (self.color, *light):
            texture.filter = moderngl.NEAREST, moderngl.NEAREST
        self.framebuffer = ctx.framebuffer([self.color])
        self._parts: dict[Surface, Part] = {}
        self._order: DepthOrder | None = None

    def part(self, surface: Surface) -> Part:
        """The part of a surface, made at first use."""
        if surface not in self._parts:
            buffer = GBuffer(self.ctx, self.size, self.color, self.light)
            self._parts[surface] = Part(buffer, PixelView(surface.visibility, buffer))
        return self._parts[surface]

    def draw(
        self, surfaces: Sequence[Surface], camera: Camera, offset: tuple[float, float], rows: int
    ) -> Iterator[None]:
        """Draw surfaces, so many rows at a time, each pixel sampled at its centre + `offset`; then each G-buffer covers
        the pixels where its surface is the nearest. Nothing is done where they hold just that.

        The last surface comes first: the objects are drawn whole and then cut where cloth hides them.
        """
        ranges = [surface.depth_range(camera) for surface in surfaces]
        far = max(far for _, far in ranges)
        depths = max(min(near for near, _ in ranges), 1e-5 * far), far
        wanted: list[Drawn] = []
        for surface in reversed(surfaces):
            wanted.append(Drawn(surface.buffers, camera, offset, depths, tuple(wanted)))
        buffers = [self.part(surface).buffer for surface in reversed(surfaces)]
        if all(buffer.drawn == one for buffer, one in zip(buffers, wanted, strict=True)):
            return
        if len(surfaces) == 1:
            yield from buffers[0].draw_bands(wanted[0], rows)
            return
        order = self._order = self._order or DepthOrder(self.ctx, self.size)
        order.clear()
        for number, (buffer, one) in enumerate(zip(buffers, wanted, strict=True)):
            buffer.forget()
            yield from buffer.draw_bands(one, rows, order.nearest if number else None)
            order.add(buffer)
        for number, buffer in enumerate(buffers):
            for later in buffers[number + 1 :]:
                buffer.cut(later)

    def clear(self) -> None:
        """Black, alpha 0, everywhere."""
        self.framebuffer.use()
        self.framebuffer.clear(0.0, 0.0, 0.0, 0.0)
        for texture in self.light:
            texture.write(bytes(16 * self.size[0] * self.size[1]))

    def read(self, part: str = "") -> np.ndarray:
        """The picture, float32 [H, W, 4], top row first; alpha: how much of a pixel is covered. Or a part of its light."""
        texture = self.light[LIGHT_PARTS.index(part)] if part else self.color
        data = np.frombuffer(texture.read(), "f4").reshape(self.size[1], self.size[0], 4)
        return data[::-1].copy()

    def release(self) -> None:
        """Free the GPU's memory."""
        for buffer, view in self._parts.values():
            buffer.release()
            view.release()
        if self._order is not None:
            self._order.release()
        self.ctx.detect_framebuffer(0).use()
        self.framebuffer.release()
        for texture in (self.color, *self.light):
            texture.release()


class Targets:
    """The targets of the last few sizes."""

    def __init__(self, ctx: moderngl.Context):
        self.ctx = ctx
        self._targets: dict[tuple, Target] = {}  # the one used last is the last

    def get(self, size: tuple[int, int], parted: bool = False) -> Target:
        """The target of a size, with parts of the light if asked for. Raises InputError where OpenGL cannot draw so large."""
        limit = self.ctx.info["GL_MAX_TEXTURE_SIZE"]
        if max(size) > limit:
            raise InputError(f"size {size[0]}x{size[1]}: this OpenGL draws at most {limit} pixels a side; choose less")
        target = self._targets.pop((size, parted), None)
        if target is None:
            while len(self._targets) >= KEPT_SIZES:
                self._targets.pop(next(iter(self._targets))).release()
            target = Target(self.ctx, size, parted)
        self._targets[size, parted] = target
        return target
