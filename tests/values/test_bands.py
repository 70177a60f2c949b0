"""Pictures drawn in parts, for a caller with other things to do, are those drawn at once, bit for bit."""

import numpy as np
import pytest

from glcloth.picture import pace
from glcloth.scene import Scene

SIZE = (131, 97)
INSIDE = {"camera": {"eye": (0.1, 0.35, 0.25)}}  # some triangles are behind the eye


@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"adaptive": True},
        {"spp": 2},
        {"shadows": "full"},
        {"adaptive": True, "shadows": "sun", "env": "sky"},
        INSIDE,
    ],
    ids=["plain", "adaptive", "samples", "shadows", "adaptive suns", "inside"],
)
def test_bands_make_the_same_picture(renderer, monkeypatch, changes):
    frame = renderer.prepare(Scene(size=SIZE, **changes))
    expected = renderer.render_frame(frame)
    names = ("frame_N", "frame_x", "frame_p", "frame_b")
    frames = [renderer.gbuffer.frame(name).read() for name in names]
    monkeypatch.setattr(pace, "BAND_PIXELS", 1500)
    renderer.gbuffer.forget()
    steps = sum(1 for _ in renderer.steps(frame, lambda: 7))
    assert steps > 14
    got = renderer.target.read()[..., :3]
    np.testing.assert_array_equal(got, expected)
    assert [renderer.gbuffer.frame(name).read() for name in names] == frames
    assert (expected > 0).any()


def test_other_drawing_between_two_parts_changes_nothing(renderer, ctx):
    """Between two steps others may bind and draw elsewhere, as the window does."""
    frame = renderer.prepare(Scene(size=SIZE, adaptive=True))
    expected = renderer.render_frame(frame)
    other = ctx.texture((8, 8), 4, dtype="f4")
    target = ctx.framebuffer([other])
    for _ in renderer.steps(frame, lambda: 9):
        target.use()
        target.clear(1.0, 0.0, 0.0, 1.0)
        for unit in range(12):
            other.use(unit)
    np.testing.assert_array_equal(renderer.target.read()[..., :3], expected)
    ctx.detect_framebuffer(0).use()
    target.release()
    other.release()
