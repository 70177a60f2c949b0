"""The sides of the picture, and the textures that they are drawn into."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import moderngl


@dataclass
class Side:
    """The present picture of a side.

    Parameters
    ----------
    texture : linear, premultiplied, bottom row first; None before the first preview
    scale : by how much it is smaller than the picture
    version : changes with every new picture
    share : 0 to 1, how much of the full picture is done; 1 only when it is `render`'s, bit for bit
    """

    texture: moderngl.Texture | None = None
    scale: float = 1.0
    share: float = 0.0
    version: int = 0

    def show(self, texture: moderngl.Texture, scale: float = 1.0) -> None:
        """Show a texture that was just drawn."""
        self.texture, self.scale = texture, scale
        self.version += 1


class Target(NamedTuple):
    """A texture and the framebuffer that draws into it."""

    texture: moderngl.Texture
    framebuffer: moderngl.Framebuffer


class Targets:
    """Targets by name; each is made anew when another size is asked for."""

    def __init__(self, ctx: moderngl.Context, dtype: str = "f4"):
        self.ctx, self._dtype = ctx, dtype
        self._targets: dict[str, Target] = {}

    def get(self, name: str, size: tuple[int, int], shown: moderngl.Texture | None = None) -> Target:
        """The target of a name. It is never the one whose texture is `shown`: two take turns."""
        found = self._targets.get(name)
        if found is not None and found.texture is shown:
            name = f"{name} again"
            found = self._targets.get(name)
        if found is None or found.texture.size != size:
            self._free(name)
            texture = self.ctx.texture(size, 4, dtype=self._dtype)
            texture.repeat_x = texture.repeat_y = False
            self._targets[name] = Target(texture, self.ctx.framebuffer([texture]))
        return self._targets[name]

    def _free(self, name: str) -> None:
        if (target := self._targets.pop(name, None)) is not None:
            self.ctx.detect_framebuffer(0).use()
            target.framebuffer.release()
            target.texture.release()

    def release(self) -> None:
        """Free all of them."""
        for name in list(self._targets):
            self._free(name)
