"""Buffers on the GPU: storage buffers, and texture buffers, which moderngl lacks and which shaders read fastest."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import moderngl
import numpy as np
from OpenGL import GL

from .context_local import of_context
from .tally import Tally

# texel format: (OpenGL internal format, bytes per texel)
_FORMATS = {
    "rgba32f": (GL.GL_RGBA32F, 16),
    "r32f": (GL.GL_R32F, 4),
    "rg32f": (GL.GL_RG32F, 8),
    "rgba32ui": (GL.GL_RGBA32UI, 16),
    "rg32ui": (GL.GL_RG32UI, 8),
    "rg32i": (GL.GL_RG32I, 8),
    "r32ui": (GL.GL_R32UI, 4),
    "r32i": (GL.GL_R32I, 4),
}
SCRATCH_UNIT = 47  # OpenGL 4.3 has at least 48 units


class Buffer:
    """A storage buffer that grows.

    Parameters
    ----------
    ctx : moderngl context, current
    data : initial content (array or bytes), or the size in bytes to reserve
    """

    least = 4  # bytes

    def __init__(self, ctx: moderngl.Context, data: Any):
        self.ctx = ctx
        self.written = 0  # bytes up to the end of the last write by the CPU; what is behind may be older
        if isinstance(data, int):
            self.buffer = ctx.buffer(reserve=max(data, self.least), dynamic=True)
        else:
            self.buffer = ctx.buffer(_bytes(data) or bytes(self.least), dynamic=True)
            self.written = len(_bytes(data))

    def _attach(self) -> None:
        """Tell what hangs on `buffer` that it is another one."""

    @property
    def size(self) -> int:
        """Bytes reserved."""
        return self.buffer.size

    def write(self, data: Any, offset: int = 0) -> None:
        """Replace the content from byte `offset` on; grow the buffer when it is too small (old content is then lost)."""
        raw = _bytes(data)
        if offset + len(raw) > self.buffer.size:
            self.reserve(offset + len(raw))
        if raw:
            self.buffer.write(raw, offset=offset)
        self.written = offset + len(raw)

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

    def read(self, size: int = -1, offset: int = 0) -> bytes:
        """Return `size` bytes from byte `offset` on (-1: all), read through a copy.

        NVIDIA's driver moves a buffer that the CPU reads into the CPU's memory, where shaders are slow on it.
        """
        size = self.buffer.size - offset if size < 0 else size
        return of_context(Staging, self.ctx).read(self.buffer, size, offset) if size else b""

    def release(self) -> None:
        """Free the buffer."""
        self.buffer.release()


class Staging:
    """The buffer that read-backs of one context go through."""

    def __init__(self, ctx: moderngl.Context):
        self.ctx = ctx
        self._copy: moderngl.Buffer | None = None
        self._tally = of_context(Tally, ctx)

    def read(self, buffer: moderngl.Buffer, size: int, offset: int) -> bytes:
        """Return `size` bytes of a buffer from byte `offset` on."""
        self._make_room(size)
        assert self._copy is not None
        self.ctx.copy_buffer(self._copy, buffer, size, read_offset=offset)
        self._tally.read(size)
        return self._copy.read(size)

    def read_all(self, parts: Sequence[tuple[Buffer, int]]) -> list[bytes]:
        """Return the first bytes of several buffers, so many of each, which the CPU waits for once."""
        total = sum(size for _, size in parts)
        self._make_room(total)
        assert self._copy is not None
        _gather(self.ctx, self._copy, parts)
        self._tally.read(total)
        return _cut(self._copy.read(total), parts)

    def _make_room(self, size: int) -> None:
        if self._copy is None or self._copy.size < size:
            if self._copy is not None:
                self._copy.release()
            self._copy = self.ctx.buffer(reserve=max(size, 1 << 16), dynamic=True)


class LateRead:
    """The first bytes of several buffers as they are now, read when the GPU has come so far: the CPU does not wait for it."""

    def __init__(self, ctx: moderngl.Context, parts: Sequence[tuple[Buffer, int]]):
        self._parts = parts
        self._copy = ctx.buffer(reserve=sum(size for _, size in parts), dynamic=True)
        _gather(ctx, self._copy, parts)
        self._fence = GL.glFenceSync(GL.GL_SYNC_GPU_COMMANDS_COMPLETE, 0)

    def data(self) -> list[bytes] | None:
        """The bytes; None where the GPU has not come so far yet."""
        if GL.glClientWaitSync(self._fence, GL.GL_SYNC_FLUSH_COMMANDS_BIT, 0) == GL.GL_TIMEOUT_EXPIRED:
            return None
        return _cut(self._copy.read(), self._parts)

    def release(self) -> None:
        """Free the memory."""
        GL.glDeleteSync(self._fence)
        self._copy.release()


def read_together(ctx: moderngl.Context, parts: Sequence[tuple[Buffer, int]]) -> list[bytes]:
    """The first bytes of several buffers, so many of each, by one read that the CPU waits for."""
    return of_context(Staging, ctx).read_all(parts)


def _gather(ctx: moderngl.Context, into: moderngl.Buffer, parts: Sequence[tuple[Buffer, int]]) -> None:
    at = 0
    for buffer, size in parts:
        ctx.copy_buffer(into, buffer.buffer, size, write_offset=at)
        at += size


def _cut(data: bytes, parts: Sequence[tuple[Buffer, int]]) -> list[bytes]:
    ends = np.cumsum([size for _, size in parts]).tolist()
    return [data[end - size : end] for end, (_, size) in zip(ends, parts, strict=True)]


def read_texture(texture: moderngl.Texture) -> bytes:
    """The content of a texture, rows from below, and counted: the CPU waits for it."""
    data = texture.read()
    of_context(Tally, texture.ctx).read(len(data))
    return data


class _Units:
    """Which texture buffer is bound at each texture unit of a context; nothing else binds any there."""

    def __init__(self, ctx: moderngl.Context):
        self.bound: dict[int, TextureBuffer] = {}


class TextureBuffer(Buffer):
    """A buffer that shaders read by `texelFetch(samplerBuffer, i)`, and that can also be bound as a storage block.

    On llvmpipe a texel fetch costs a tenth of a storage-buffer load. A shader must not read it by texelFetch in the
    same dispatch that writes it as a block.

    Parameters
    ----------
    ctx, data : as for Buffer
    format : texel format, one of rgba32f r32f rgba32ui rg32ui rg32i r32ui r32i
    """

    def __init__(self, ctx: moderngl.Context, data: Any, format: str = "rgba32f"):
        self._format, self.texel_bytes = _FORMATS[format]
        self.least = self.texel_bytes
        super().__init__(ctx, data)
        self._texture = int(GL.glGenTextures(1))
        self._units = of_context(_Units, ctx).bound
        self._attach()

    def _attach(self) -> None:
        # On a unit that no shader uses, so that a buffer which grows between binding and drawing unbinds nothing.
        GL.glActiveTexture(GL.GL_TEXTURE0 + SCRATCH_UNIT)
        GL.glBindTexture(GL.GL_TEXTURE_BUFFER, self._texture)
        GL.glTexBuffer(GL.GL_TEXTURE_BUFFER, self._format, self.buffer.glo)
        GL.glBindTexture(GL.GL_TEXTURE_BUFFER, 0)
        GL.glActiveTexture(GL.GL_TEXTURE0)

    def bind(self, unit: int) -> None:
        """Bind for reading at a texture unit."""
        if self._units.get(unit) is self:
            return
        self._units[unit] = self
        GL.glActiveTexture(GL.GL_TEXTURE0 + unit)
        GL.glBindTexture(GL.GL_TEXTURE_BUFFER, self._texture)
        GL.glActiveTexture(GL.GL_TEXTURE0)

    def release(self) -> None:
        """Free the texture and the buffer."""
        GL.glDeleteTextures(1, [self._texture])
        super().release()


def _bytes(data: Any) -> bytes | bytearray:
    return data if isinstance(data, bytes | bytearray) else np.ascontiguousarray(data).tobytes()
