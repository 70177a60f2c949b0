"""The screen shows what color.py says: the display shader against NumPy over its range, transparency and differences."""

from types import SimpleNamespace

import moderngl
import numpy as np
import pytest

from glcloth.color import VIEW_TRANSFORMS, srgb_encode, view
from glcloth.fabric import load_fabric
from glcloth.geometry.mesh import Mesh
from glcloth.gpu.memo import Last
from glcloth.light.lights import SphericalGaussians
from glcloth.ocio import OcioView
from glcloth.picture.renderer import Renderer
from glcloth.scene import Scene
from glcloth.window.actions import Actions
from glcloth.window.drawing import Drawing
from glcloth.window.pictures import Side
from glcloth.window.screen import Look, Screen
from glcloth.window.state import Session


@pytest.fixture
def screen(ctx):
    made = Screen(ctx)
    yield made
    made.release()


def side(ctx, picture):
    """A side that shows [H, W, 4], top row first."""
    height, width = picture.shape[:2]
    texture = ctx.texture((width, height), 4, picture[::-1].astype("f4").tobytes(), dtype="f4")
    texture.filter = moderngl.NEAREST, moderngl.NEAREST
    return Side(texture=texture, share=1.0, version=1)


def shown(screen, sides, *arguments):
    code = screen.encode(0, sides, *arguments).texture
    return np.frombuffer(code.read(), "u1").reshape(code.height, code.width, 4)[::-1, :, :3].astype(int)


def colors():
    """[H, W, 3]: greys and colours from 1e-7 to beyond 2^15, zero, negative, infinite, not a number, and the curves' joints."""
    rng = np.random.default_rng(3)
    greys = np.repeat(np.concatenate([[0.0], np.logspace(-7, 5, 4095)])[:, None], 3, 1)
    mixed = 10 ** rng.uniform(-5, 3, (4096, 3)) * (rng.random((4096, 3)) > 0.1)
    near = np.repeat(np.linspace(0.0, 2.0, 4096)[:, None], 3, 1) * [1.0, 0.9, 0.7]
    joints = [
        0.0031308,
        0.04045,
        0.04,
        0.08,
        0.76,
        0.8,
        11.2,
        2.0**15,
        2.0**16,
        1e30,
        np.inf,
        -np.inf,
        np.nan,
        -1.0,
        -1e-9,
    ]
    odd = np.array([[a, b, 0.3] for a in joints for b in joints])
    odd = np.concatenate([odd, np.zeros((4096 - len(odd), 3))])
    return np.stack([greys, mixed, near, odd]).reshape(128, 128, 3)


@pytest.mark.parametrize("exposure", [-3.0, 0.0, 2.5])
@pytest.mark.parametrize("transform", list(VIEW_TRANSFORMS))
def test_every_view_transform_is_that_of_color_py(ctx, screen, transform, exposure):
    rgb = colors()
    one = side(ctx, np.concatenate([rgb, np.ones((128, 128, 1))], -1))
    got = shown(screen, [one], Look(exposure, transform))
    expected = 255 * view(rgb.astype("f4"), transform, exposure)
    # Eight bits round to half a code; float32 moves a value across that line now and then.
    assert np.abs(got - expected).max() <= 0.52
    assert (got == np.round(expected)).mean() > 0.999
    one.texture.release()


def test_a_view_of_a_config_is_read_from_its_table(ctx, screen):
    """Grid colours are exact; between them the table is linear in stops, and so is this view."""

    class Stops:
        def __call__(self, rgb):
            return np.clip((np.log2(np.maximum(rgb, 1e-9)) + 12) / 20, 0.0, 1.0) * (1.0, 0.5, 0.25)

        @property
        def lut(self):
            return OcioView.lut.func(self)

    stops = Stops()
    rgb = np.exp2(np.random.default_rng(0).uniform(-9, 7, (32, 32, 3)))
    one = side(ctx, np.concatenate([rgb, np.ones((32, 32, 1))], -1))
    got = shown(screen, [one], Look(0.5, stops))
    assert np.abs(got - 255 * view(rgb.astype("f4"), stops, 0.5)).max() <= 1.5
    assert np.abs(shown(screen, [one], Look(0.5, "agx")) - 255 * view(rgb.astype("f4"), "agx", 0.5)).max() <= 0.52
    one.texture.release()


def test_what_is_transparent_lies_on_grey(ctx, screen):
    cover = np.linspace(0.0, 1.0, 64)[None, :, None] * np.ones((4, 1, 1))
    rgb = np.full((4, 64, 3), (0.5, 0.2, 0.05))
    one = side(ctx, np.concatenate([rgb * cover, cover], -1))
    got = shown(screen, [one], Look(0.0, "standard", False))
    expected = 255 * (0.16 * (1 - cover) + srgb_encode(rgb) * cover)
    assert np.abs(got - expected).max() <= 0.52
    one.texture.release()


def test_the_near_view_shows_the_chosen_part_as_the_picture_is_shown(ctx):
    """Its fabric at its own size, without maps of the garment; through the config's view, where there is one."""
    pytest.importorskip("PyOpenColorIO")
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], float)
    parts = [
        Mesh.from_arrays(corners + n, np.array([[0, 1, 2]]), corners[:, :2], name=name) for n, name in enumerate("ab")
    ]
    scene = Scene(fabric="linen", fabrics={"b": "houndstooth"}, uv_scale=3.0, ocio="ocio://default")
    drawing = Drawing.__new__(Drawing)
    drawing.ctx, drawing.near, drawing.session, drawing._transforms = ctx, None, Session(scene), Last()
    frame = Renderer(ctx=ctx).prepare(scene, mesh=parts, lights=SphericalGaussians([(0, 0, 1)], [1.0], [(1, 1, 1)]))
    drawing.refiner = SimpleNamespace(frames=[frame])
    for part, fabric in (("", "linen"), ("b", "houndstooth")):
        drawing.session.choose_part(part)
        near = drawing.look_near()
        (cloth,) = near._frame.cloths
        assert cloth.fabric == load_fabric(fabric) and near._frame.scene.uv_scale == 1.0
    near.release()
    looks = []
    drawing.near = SimpleNamespace(show=lambda *_: None, texture=looks.append, aspect=2.0)
    Actions.near_picture(SimpleNamespace(_drawing=drawing))
    assert isinstance(looks[0].view_transform, OcioView)


def test_a_difference_is_scaled_and_has_no_view_transform(ctx, screen):
    rng = np.random.default_rng(0)
    a, b = rng.random((2, 16, 16, 4))
    sides = [side(ctx, a), side(ctx, b)]
    got = shown(screen, sides, Look(3.0, "agx"), 4.0)
    expected = 255 * srgb_encode(4.0 * np.abs(a - b)[..., :3])
    assert np.abs(got - expected).max() <= 0.52
    for one in sides:
        one.texture.release()
