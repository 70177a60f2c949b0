"""Linear pictures on the screen: encoded once in their own size, then shown as often as the panels change."""

from __future__ import annotations

from typing import Literal, NamedTuple

import moderngl
import numpy as np
from OpenGL import GL

from ..color import VIEW_TRANSFORMS, Transform
from ..gpu.memo import Last
from ..gpu.programs import Draw, programs
from ..gpu.screen import draw_screen
from .pictures import Side, Target, Targets

Rectangle = tuple[int, int, int, int]  # left, bottom, width, height in pixels


class Look(NamedTuple):
    """How a linear picture is shown. `opaque`: something is behind the cloth everywhere."""

    exposure: float = 0.0
    view_transform: Transform = "standard"
    opaque: bool = True


class Screen:
    """Encodes the sides with exposure and view transform and puts them into the window's framebuffer."""

    def __init__(self, ctx: moderngl.Context):
        self.ctx = ctx
        self._codes = Targets(ctx, "f1")
        self._drawn: tuple[Last, Last] = Last(), Last()
        self._table: Last[None] = Last()
        self._lut = _table(ctx, np.zeros((1, 1, 1, 3), np.float32))

    def compiled(self) -> Draw:
        """The program. Raises ShaderError."""
        return programs(self.ctx).screen("passes/window/display.frag")

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
            codes = [self.encode(0, sides, look, difference_scale)]
        else:
            wanted = sides if compare == "split" else sides[:1]
            codes = [self.encode(number, [side], look) for number, side in enumerate(wanted)]
        screen = self.ctx.detect_framebuffer(0)
        ends = [0.0, split, 1.0] if len(codes) > 1 else [0.0, 1.0]
        for code, begin, end in zip(codes, ends[:-1], ends[1:], strict=True):
            _blit(code, screen, rectangle, begin, end)
        screen.use()

    def encode(self, number: int, sides: list[Side], look: Look, difference_scale: float = 0.0) -> Target:
        """The 8-bit picture of one side, or of the difference of two."""
        textures = [side.texture for side in sides]
        size = max((texture.size for texture in textures), key=lambda size: size[0])
        code = self._codes.get(str(number), size)
        versions = tuple((side.texture, side.version) for side in sides)
        if self._drawn[number].changes(code.texture, versions, look, difference_scale):
            for texture in textures:
                texture.filter = 2 * (moderngl.NEAREST if texture.size == size else moderngl.LINEAR,)
            draw_screen(
                self.compiled(),
                code.framebuffer,
                picture_a=textures[0],
                picture_b=textures[-1],
                extent=(float(size[0]), float(size[1])),
                exposure=look.exposure,
                view_transform=self._number(look.view_transform),
                config_view=self._lut,
                difference_scale=difference_scale,
                opaque=look.opaque,
            )
            for texture in textures:
                texture.filter = moderngl.LINEAR, moderngl.LINEAR
        return code

    def _number(self, transform: Transform) -> int:
        """The number of a view transform in the shader; that of a config is read from a table."""
        if isinstance(transform, str):
            return list(VIEW_TRANSFORMS).index(transform)
        self._table.get(lambda: self._take(transform.lut), transform)  # type: ignore[union-attr]
        return len(VIEW_TRANSFORMS)

    def _take(self, lut: np.ndarray) -> None:
        self._lut.release()
        self._lut = _table(self.ctx, lut)

    def release(self) -> None:
        """Free the textures."""
        self._lut.release()
        self._codes.release()


def _table(ctx: moderngl.Context, lut: np.ndarray) -> moderngl.Texture3D:
    """A texture of a table [blue, green, red, 3]."""
    texture = ctx.texture3d(lut.shape[2::-1], 3, np.ascontiguousarray(lut), dtype="f4")
    texture.filter = moderngl.LINEAR, moderngl.LINEAR
    texture.repeat_x = texture.repeat_y = texture.repeat_z = False
    return texture


def _blit(code: Target, screen: moderngl.Framebuffer, rectangle: Rectangle, begin: float, end: float) -> None:
    """Copy the columns from `begin` to `end` (shares of the width), scaled where the sizes differ."""
    left, bottom, width, height = rectangle
    size = code.texture.size
    source = round(begin * size[0]), 0, round(end * size[0]), size[1]
    target = left + round(begin * width), bottom, left + round(end * width), bottom + height
    # A copy by OpenGL itself costs a tenth of a drawn rectangle on a software rasteriser.
    GL.glBindFramebuffer(GL.GL_READ_FRAMEBUFFER, code.framebuffer.glo)
    GL.glBindFramebuffer(GL.GL_DRAW_FRAMEBUFFER, screen.glo)
    GL.glDisable(GL.GL_SCISSOR_TEST)
    filter = GL.GL_NEAREST if size == (width, height) else GL.GL_LINEAR
    GL.glBlitFramebuffer(*source, *target, GL.GL_COLOR_BUFFER_BIT, filter)
