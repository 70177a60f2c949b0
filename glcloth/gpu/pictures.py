"""Pictures on the GPU whose mip levels have their mean, exactly."""

from __future__ import annotations

import math

import moderngl
import numpy as np
from OpenGL import GL

from ..errors import InputError

LARGEST = 4096  # texels a side


def even_size(height: int, width: int, most: int = LARGEST * LARGEST) -> tuple[int, int]:
    """The powers of two (height, width) that hold a picture, or the next smaller ones where it has more than `most` texels."""
    size = [min(1 << max(0, math.ceil(math.log2(side))), LARGEST) for side in (height, width)]
    while size[0] * size[1] > most:
        size[size[0] < size[1]] //= 2
    return size[0], size[1]


def resampled(picture: np.ndarray, size: tuple[int, int]) -> np.ndarray:
    """A picture [H, W, C] with other sides; each texel is the mean over its area, so that the whole keeps its mean."""
    for axis, count in enumerate(size):
        if picture.shape[axis] == count:
            continue
        at = np.linspace(0.0, picture.shape[axis], count + 1)
        sums = np.concatenate(
            [np.zeros_like(picture[:1] if axis == 0 else picture[:, :1], float), np.cumsum(picture, axis, float)], axis
        )
        low = np.minimum(at.astype(int), picture.shape[axis] - 1)
        part = (at - low).reshape((-1, 1, 1) if axis == 0 else (1, -1, 1))
        whole = np.take(sums, low, axis) + part * np.take(picture, low, axis)
        picture = np.diff(whole, axis=axis) * (count / picture.shape[axis])
    return np.ascontiguousarray(picture, np.float32)


def picture_array(ctx: moderngl.Context, layers: np.ndarray) -> moderngl.TextureArray:
    """A texture array of half floats of layers [N, H, W, C <= 4], the first row at v = 0, that repeats; sides are powers of
    two. Its levels are made here, for drivers round half floats down. Raises InputError for more layers than the device has."""
    count, height, width, channels = layers.shape
    most = ctx.info["GL_MAX_ARRAY_TEXTURE_LAYERS"]
    if count > most:
        raise InputError(
            f"{count} different pictures on the objects, expected at most {most} on this device; leave some out"
        )
    texture = ctx.texture_array((width, height, count), 4, dtype="f2")
    texture.build_mipmaps()  # makes room
    texture.filter = moderngl.LINEAR_MIPMAP_LINEAR, moderngl.LINEAR
    GL.glBindTexture(GL.GL_TEXTURE_2D_ARRAY, texture.glo)
    for k, layer in enumerate(layers):  # one after the other, for memory
        level, number = np.asarray(layer, np.float32), 0
        while True:
            data = np.ones((*level.shape[:2], 4), "f2")
            data[..., :channels] = np.minimum(level, 65504.0)
            GL.glTexSubImage3D(
                GL.GL_TEXTURE_2D_ARRAY, number, 0, 0, k, level.shape[1], level.shape[0], 1, GL.GL_RGBA,
                GL.GL_HALF_FLOAT, data,
            )  # fmt: skip
            if level.shape[0] == level.shape[1] == 1:
                break
            if level.shape[0] > 1:
                level = 0.5 * (level[::2] + level[1::2])
            if level.shape[1] > 1:
                level = 0.5 * (level[:, ::2] + level[:, 1::2])
            number += 1
    GL.glBindTexture(GL.GL_TEXTURE_2D_ARRAY, 0)
    return texture
