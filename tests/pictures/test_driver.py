"""What a driver says or keeps beside the pixels."""

import gc

import OpenGL.GL as GL
import pytest

from glcloth.errors import DriverError
from glcloth.gpu.gbuffer import GBuffer
from glcloth.picture.renderer import Renderer
from glcloth.picture.target import KEPT_SIZES, Targets


def test_what_opengl_refuses_is_an_error_of_the_picture(renderer, monkeypatch):
    frame = renderer.prepare(mesh="plane", lobes=2, size=(16, 12))
    refused = [0xFFFF]  # no capability of OpenGL

    def draw(self, frame):
        self._target = self._targets.get(frame.scene.size)
        self._target.clear()
        for number in refused:
            GL.glEnable(number)

    monkeypatch.setattr(Renderer, "draw", draw)
    with pytest.raises(DriverError, match="method direct: OpenGL reports GL_INVALID_ENUM"):
        renderer.render_frame(frame)
    refused.clear()
    assert renderer.render_frame(frame).shape == (12, 16, 3)


def test_pictures_of_ever_other_sizes_keep_few_buffers(renderer):
    def buffers():
        gc.collect()
        return sum(isinstance(o, GBuffer) for o in gc.get_objects())

    before, targets = buffers(), Targets(renderer.ctx)
    for width in range(16, 16 + 3 * KEPT_SIZES):
        targets.get((width, 12)).part(renderer.stage.cloths[0])
    assert buffers() - before == KEPT_SIZES
