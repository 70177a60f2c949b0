"""The picture of one size on the GPU, and the G-buffer of each surface that is shaded into it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import moderngl
import numpy as np

from ..errors import InputError
from ..geometry.camera import Camera
from ..gpu.buffers import read_texture
from ..gpu.gbuffer import DepthOrder, Drawn, GBuffer
from ..gpu.programs import programs
from ..gpu.screen import draw_screen
from ..visibility.pixels import PixelView
from .surface import Surface

LIGHT_PARTS = ("bounce", "transmission")
MOST_LAYERS = 4  # of cloth that are seen through
KEPT_SIZES = 3  # pictures that stay when the size changes, so that a window can change between two

# The near distance over the far one, at least: a ground that ends in kilometres leaves 7 mm before the eye, in steps of depth
# (24 bits) of a hundredth of a millimetre at a metre, and all but the last fifth of the way to the horizon told from no surface.
NEAREST_OF_FAR = 5e-7


class Part(NamedTuple):
    """One surface on a target: its frames and depth, and how far these pixels see the lights."""

    buffer: GBuffer
    view: PixelView


class Layer:
    """What is seen through cloth behind one layer of it: a picture of its own, and how much of its light is left."""

    def __init__(self, ctx: moderngl.Context, size: tuple[int, int]):
        self.color = ctx.texture(size, 4, dtype="f4")
        self.left = ctx.texture(size, 4, dtype="f2")
        for texture in (self.color, self.left):
            texture.filter = moderngl.NEAREST, moderngl.NEAREST
        self.target, self.left_target = ctx.framebuffer([self.color]), ctx.framebuffer([self.left])
        self.cloth = DepthOrder(ctx, size)  # of the layer before it: the cloth that is seen through

    def release(self) -> None:
        """Free the GPU's memory."""
        for thing in (self.target, self.left_target, self.color, self.left, self.cloth):
            thing.release()


class Target:
    """A colour texture, and a part for each surface; with `parted`, more textures for parts of the light; and where cloth
    is seen through, layers behind it.

    The layers are found by depth peeling: each holds of all surfaces what is nearest behind the sheer cloth of the layer
    before it. The last one has no sheer cloth, so that behind MOST_LAYERS of them objects and ground still stand.
    """

    def __init__(self, ctx: moderngl.Context, size: tuple[int, int], parted: bool = False):
        self.ctx, self.size = ctx, size
        self.color, *light = (ctx.texture(size, 4, dtype="f4") for _ in range(1 + len(LIGHT_PARTS) * parted))
        self.light = tuple(light)  # LIGHT_PARTS, as inputs/picture/parts.glsl has them
        for texture in (self.color, *light):
            texture.filter = moderngl.NEAREST, moderngl.NEAREST
        self.framebuffer = ctx.framebuffer([self.color])
        self._whole = ctx.framebuffer([self.color, *self.light]) if parted else self.framebuffer
        self._parts: dict[tuple[Surface, int], Part] = {}
        self._order: DepthOrder | None = None
        self._layers: list[Layer] = []  # behind the first

    def part(self, surface: Surface, layer: int = 0) -> Part:
        """The part of a surface in a layer, made at first use."""
        if (surface, layer) not in self._parts:
            picture = (self._layers[layer - 1].color,) if layer else (self.color, self.light)
            buffer = GBuffer(self.ctx, self.size, *picture)
            self._parts[surface, layer] = Part(buffer, PixelView(surface.visibility, buffer))
        return self._parts[surface, layer]

    def parts(self, surfaces: Sequence[Surface]) -> list[tuple[Surface, Part]]:
        """The surfaces with their parts, in all layers."""
        return [
            (one, self.part(one, layer))
            for layer in range(1 + len(self._layers))
            for one in self._in_layer(surfaces, layer)
        ]

    def _in_layer(self, surfaces: Sequence[Surface], layer: int) -> Sequence[Surface]:
        return surfaces if layer < MOST_LAYERS else [surface for surface in surfaces if not surface.sheer]

    def draw(
        self, surfaces: Sequence[Surface], camera: Camera, offset: tuple[float, float], rows: int
    ) -> Iterator[None]:
        """Draw surfaces, so many rows at a time, each pixel sampled at its centre + `offset`; then each G-buffer covers
        the pixels where its surface is the nearest of its layer. Nothing is done where they hold just that.

        The last surface comes first: the objects are drawn whole and then cut where cloth hides them.
        """
        ranges = [surface.depth_range(camera) for surface in surfaces]
        far = max(far for _, far in ranges)
        depths = max(min(near for near, _ in ranges), NEAREST_OF_FAR * far), far
        self._reserve(MOST_LAYERS if any(surface.sheer for surface in surfaces) else 0)
        drawn: tuple[Drawn, ...] = ()
        sheer: tuple[bool, ...] = ()
        for layer in range(1 + len(self._layers)):
            here = self._in_layer(surfaces, layer)
            wanted: list[Drawn] = []
            for surface in reversed(here):
                one = Drawn(surface.buffers, camera, offset, depths, tuple(wanted), drawn, sheer)
                held = self.part(surface, layer).buffer.drawn
                # What is held already stands for its equal: without such identity a comparison would go through all that
                # stands before and behind, and through what stands before and behind that, again and again.
                wanted.append(held if held == one else one)
            yield from self._draw_layer(layer, here, wanted, rows, surfaces)
            drawn, sheer = tuple(wanted), tuple(surface.sheer for surface in reversed(here))

    def _draw_layer(
        self, layer: int, here: Sequence[Surface], wanted: list[Drawn], rows: int, surfaces: Sequence[Surface]
    ) -> Iterator[None]:
        buffers = [self.part(surface, layer).buffer for surface in reversed(here)]
        if all(buffer.drawn == one for buffer, one in zip(buffers, wanted, strict=True)):
            return
        behind = self._cloth_before(layer, surfaces) if layer else None
        if len(here) == 1:
            yield from buffers[0].draw_bands(wanted[0], rows, None, behind)
            return
        order = self._order = self._order or DepthOrder(self.ctx, self.size)
        order.clear()
        for number, (buffer, one) in enumerate(zip(buffers, wanted, strict=True)):
            buffer.forget()
            yield from buffer.draw_bands(one, rows, order.nearest if number else None, behind)
            order.add(buffer)
        for number, buffer in enumerate(buffers):
            for later in buffers[number + 1 :]:
                buffer.cut(later)

    # -- layers ------------------------------------------------------------------------------------------------------

    def _reserve(self, count: int) -> None:
        """Have so many layers behind the first; their memory is freed when there are none."""
        while len(self._layers) < count:
            self._layers.append(Layer(self.ctx, self.size))
        if len(self._layers) > count:
            self.ctx.detect_framebuffer(0).use()
            for surface, layer in [key for key in self._parts if key[1] > count]:
                for thing in self._parts.pop((surface, layer)):
                    thing.release()
            while len(self._layers) > count:
                self._layers.pop().release()

    def _cloth_before(self, layer: int, surfaces: Sequence[Surface]) -> moderngl.Texture:
        """The depth of the sheer cloth in the layer before this one; the far plane's elsewhere."""
        cloth = self._layers[layer - 1].cloth
        cloth.clear()
        for surface in self._in_layer(surfaces, layer - 1):
            if surface.sheer:
                cloth.add(self.part(surface, layer - 1).buffer)
        return cloth.nearest

    def clear_layers(self) -> None:
        """Black, alpha 0, in all layers but the first."""
        for layer in self._layers:
            layer.target.use()
            layer.target.clear(0.0, 0.0, 0.0, 0.0)

    def attenuate(self, surfaces: Sequence[Surface]) -> None:
        """Find how much of the light of each layer is left."""
        for number, layer in enumerate(self._layers):
            layer.left_target.use()
            layer.left_target.clear(0.0, 0.0, 0.0, 0.0)
            for surface in self._in_layer(surfaces, number):
                if not surface.sheer:
                    continue
                buffer = self.part(surface, number).buffer
                before = {"left": self._layers[number - 1].left} if number else {}
                values = {**surface.straight_inputs(buffer), **before, "first": number == 0}
                draw_screen(surface.straight_program(buffer), layer.left_target, buffer.inputs(), values, blend="add")

    def composite(self, beyond_weight: float, environment: dict[str, Any] | None, catches: bool) -> None:
        """Add the layers to the picture as far as their light is left; and where nothing is left to be seen behind
        them, the environment, or, without one, transparency.

        Parameters
        ----------
        beyond_weight : share of this sample in the pixel; 0: the environment is there already
        environment : what passes/picture/composite.frag reads of it; None: none
        catches : whether a surface shows its shadow alone, and so covers a part of a pixel
        """
        if not self._layers:
            return
        program = programs(self.ctx).screen("passes/picture/composite.frag", {"PARTS": 1} if self.light else None)
        values = {
            **(environment or {}),
            "has_environment": environment is not None,
            "beyond_weight": beyond_weight,
            "catches": catches,
        }
        for layer in self._layers:
            draw_screen(program, self._whole, values, blend="add", left=layer.left, layer=layer.color)

    def nearest(self, surfaces: Sequence[Surface]) -> moderngl.Texture:
        """The depth of what is nearest, as it is drawn."""
        order = self._order = self._order or DepthOrder(self.ctx, self.size)
        order.clear()
        for surface in surfaces:
            order.add(self.part(surface).buffer)
        return order.nearest

    @property
    def layered(self) -> bool:
        """Whether the last draw had cloth that is seen through."""
        return bool(self._layers)

    def clear(self) -> None:
        """Black, alpha 0, everywhere."""
        self.framebuffer.use()
        self.framebuffer.clear(0.0, 0.0, 0.0, 0.0)
        for texture in self.light:
            texture.write(bytes(16 * self.size[0] * self.size[1]))

    def read(self, part: str = "") -> np.ndarray:
        """The picture, float32 [H, W, 4], top row first; alpha: how much of a pixel is covered. Or a part of its light."""
        texture = self.light[LIGHT_PARTS.index(part)] if part else self.color
        data = np.frombuffer(read_texture(texture), "f4").reshape(self.size[1], self.size[0], 4)
        return data[::-1].copy()

    def release(self) -> None:
        """Free the GPU's memory."""
        for buffer, view in self._parts.values():
            buffer.release()
            view.release()
        if self._order is not None:
            self._order.release()
        for layer in self._layers:
            layer.release()
        self.ctx.detect_framebuffer(0).use()
        self.framebuffer.release()
        if self._whole is not self.framebuffer:
            self._whole.release()
        for texture in (self.color, *self.light):
            texture.release()


class Targets:
    """The targets of the last few sizes."""

    def __init__(self, ctx: moderngl.Context):
        self.ctx = ctx
        self._targets: dict[tuple, Target] = {}  # the one used last is the last

    def holds(self, target: Target) -> bool:
        """Whether a target is one of them still."""
        return target in self._targets.values()

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
