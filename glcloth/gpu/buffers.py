"""Buffers on the GPU: texture buffers, which moderngl lacks and which shaders read fastest."""

from __future__ import annotations

import moderngl
import numpy as np
from OpenGL import GL

# texel format: (OpenGL internal format, bytes per texel)
_FORMATS = {
    "rgba32f": (GL.GL_RGBA32F, 16),
    "rg32f": (GL.GL_RG32F, 8),
    "r32f": (GL.GL_R32F, 4),
    "rgba16f": (GL.GL_RGBA16F, 8),
    "rgba32ui": (GL.GL_RGBA32UI, 16),
    "rg32ui": (GL.GL_RG32UI, 8),
    "rg32i": (GL.GL_RG32I, 8),
    "r32ui": (GL.GL_R32UI, 4),
    "r32i": (GL.GL_R32I, 4),
}
SCRATCH_UNIT = 47  # OpenGL 4.3 has at least 48 units


class TextureBuffer:
    """A buffer that shaders read by `texelFetch(samplerBuffer, i)`; `.buffer` can also be bound as a storage buffer.

    On llvmpipe a texel fetch costs a tenth of a storage-buffer load. A shader must not read it by texelFetch in the
    same dispatch that writes `.buffer`.

    Parameters
    ----------
    ctx : moderngl context, current
    data : initial content (array or bytes), or the size in bytes to reserve
    format : texel format, one of rgba32f rg32f r32f rgba16f rgba32ui rg32ui rg32i r32ui r32i
    """

    def __init__(self, ctx: moderngl.Context, data, format: str = "rgba32f"):
        self.ctx = ctx
        self._format, self.texel_bytes = _FORMATS[format]
        if isinstance(data, int):
            self.buffer = ctx.buffer(reserve=max(data, self.texel_bytes), dynamic=True)
        else:
            self.buffer = ctx.buffer(_bytes(data) or bytes(self.texel_bytes), dynamic=True)
        self._texture = int(GL.glGenTextures(1))
        self._attach()

    def _attach(self) -> None:
        # On a unit that no shader uses, so that a buffer which grows between binding and drawing unbinds nothing.
        GL.glActiveTexture(GL.GL_TEXTURE0 + SCRATCH_UNIT)
        GL.glBindTexture(GL.GL_TEXTURE_BUFFER, self._texture)
        GL.glTexBuffer(GL.GL_TEXTURE_BUFFER, self._format, self.buffer.glo)
        GL.glBindTexture(GL.GL_TEXTURE_BUFFER, 0)
        GL.glActiveTexture(GL.GL_TEXTURE0)

    @property
    def size(self) -> int:
        """Bytes reserved."""
        return self.buffer.size

    def write(self, data, offset: int = 0) -> None:
        """Replace the content from byte `offset` on; grow the buffer when it is too small (old content is then lost)."""
        raw = _bytes(data)
        if offset + len(raw) > self.buffer.size:
            self.reserve(offset + len(raw))
        if raw:
            self.buffer.write(raw, offset=offset)

    def reserve(self, size: int) -> None:
        """Make room for at least `size` bytes; the content is undefined after it grew."""
        if size > self.buffer.size:
            self.buffer.orphan(max(size, self.buffer.size * 3 // 2))
            self._attach()

    def extend(self, size: int) -> None:
        """Make room for at least `size` bytes; the content stays."""
        if size > self.buffer.size:
            old, self.buffer = self.buffer, self.ctx.buffer(reserve=max(size, self.buffer.size * 3 // 2), dynamic=True)
            self.ctx.copy_buffer(self.buffer, old, size=old.size)
            old.release()
            self._attach()

    def bind(self, unit: int) -> None:
        """Bind for reading at a texture unit (the shader says `layout(binding = unit) uniform samplerBuffer ...`)."""
        GL.glActiveTexture(GL.GL_TEXTURE0 + unit)
        GL.glBindTexture(GL.GL_TEXTURE_BUFFER, self._texture)
        GL.glActiveTexture(GL.GL_TEXTURE0)

    def release(self) -> None:
        """Free the texture and the buffer."""
        GL.glDeleteTextures(1, [self._texture])
        self.buffer.release()


def _bytes(data) -> bytes:
    return data if isinstance(data, bytes | bytearray) else np.ascontiguousarray(data).tobytes()
