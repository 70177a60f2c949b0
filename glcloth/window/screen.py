"""Linear pictures on the screen: encoded once in their own size, then shown as often as the panels change."""

from __future__ import annotations

from typing import Literal, NamedTuple

import moderngl
from OpenGL import GL

from ..color import VIEW_TRANSFORMS
from ..gpu import shader
from .refine import Side

Rectangle = tuple[int, int, int, int]  # left, bottom, width, height in pixels


class Look(NamedTuple):
    """How a linear picture is shown. `opaque`: something is behind the cloth everywhere."""

    exposure: float = 0.0
    view_transform: str = "standard"
    opaque: bool = True


class Screen:
    """Encodes the sides with exposure and view transform and puts them into the window's framebuffer."""

    def __init__(self, ctx: moderngl.Context):
        self.ctx = ctx
        self._encode = shader.program(ctx, "passes/picture/screen.vert", "passes/window/display.frag")
        self._array = ctx.vertex_array(self._encode, [])
        self._codes: list[tuple[moderngl.Texture, moderngl.Framebuffer] | None] = [None, None]
        self._keys: list[tuple | None] = [None, None]

    def draw(
        self,
        sides: list[Side],
        look: Look,
        rectangle: Rectangle,
        compare: Literal["off", "split", "difference"] = "off",
        split: float = 0.5,
        difference_scale: float = 8.0,
    ) -> None:
        """Draw into a rectangle of the window; the framebuffer is left bound."""
        sides = [side for side in sides if side.texture is not None]
        if not sides:
            return
        compare = compare if len(sides) > 1 else "off"
        if compare == "difference":
            pictures = [self.encode(0, sides, look, difference_scale)]
        else:
            wanted = sides if compare == "split" else sides[:1]
            pictures = [self.encode(number, [side], look) for number, side in enumerate(wanted)]
        screen = self.ctx.detect_framebuffer(0)
        shares = [split, 1.0 - split] if len(pictures) > 1 else [1.0]
        begin = 0.0
        for number, (picture, share) in enumerate(zip(pictures, shares, strict=True)):
            self._blit(self._codes[number][1], picture.size, screen, rectangle, begin, begin + share)
            begin += share
        screen.use()

    @staticmethod
    def _blit(source, size: tuple[int, int], screen, rectangle: Rectangle, begin: float, end: float) -> None:
        """Copy the columns from `begin` to `end` (shares of the width), scaled where the sizes differ."""
        left, bottom, width, height = rectangle
        x0, x1 = round(begin * width), round(end * width)
        exact = size == (width, height)
        # A copy by OpenGL itself costs a tenth of a drawn rectangle on a software rasteriser.
        GL.glBindFramebuffer(GL.GL_READ_FRAMEBUFFER, source.glo)
        GL.glBindFramebuffer(GL.GL_DRAW_FRAMEBUFFER, screen.glo)
        GL.glDisable(GL.GL_SCISSOR_TEST)
        GL.glBlitFramebuffer(
            round(begin * size[0]),
            0,
            round(end * size[0]),
            size[1],
            left + x0,
            bottom,
            left + x1,
            bottom + height,
            GL.GL_COLOR_BUFFER_BIT,
            GL.GL_NEAREST if exact else GL.GL_LINEAR,
        )

    def encode(self, number: int, sides: list[Side], look: Look, difference_scale: float = 0.0) -> moderngl.Texture:
        """The 8-bit picture of one side, or of the difference of two."""
        size = max((side.texture.size for side in sides), key=lambda size: size[0])
        versions = tuple((side.texture, side.version) for side in sides)
        key = versions, look, difference_scale
        target = self._codes[number]
        if target is None or target[0].size != size:
            self._free(number)
            texture = self.ctx.texture(size, 4)
            texture.repeat_x = texture.repeat_y = False
            target = self._codes[number] = texture, self.ctx.framebuffer([texture])
        if self._keys[number] != key:
            self._keys[number] = key
            for unit, side in enumerate(sides):
                filter = moderngl.NEAREST if side.texture.size == size else moderngl.LINEAR
                side.texture.filter = filter, filter
                side.texture.use(unit)
            shader.set_uniforms(
                self._encode,
                extent=(float(size[0]), float(size[1])),
                exposure=look.exposure,
                view_transform=list(VIEW_TRANSFORMS).index(look.view_transform),
                difference_scale=difference_scale,
                opaque=look.opaque,
            )
            target[1].use()
            self.ctx.viewport = (0, 0, *size)
            self.ctx.enable_only(moderngl.NOTHING)
            self._array.render(moderngl.TRIANGLES, vertices=3)
            for side in sides:
                side.texture.filter = moderngl.LINEAR, moderngl.LINEAR
        return target[0]

    def _free(self, number: int) -> None:
        if self._codes[number] is not None:
            self.ctx.detect_framebuffer(0).use()
            texture, framebuffer = self._codes[number]
            framebuffer.release()
            texture.release()
            self._codes[number] = self._keys[number] = None

    def release(self) -> None:
        """Free textures and programs."""
        for number in (0, 1):
            self._free(number)
        self._array.release()
        self._encode.release()
