"""A ground that shows its shadow alone: over the environment, as alpha, fading out, and in closed form."""

import numpy as np
import pytest

from glcloth.fabric import load_fabric
from glcloth.geometry.camera import Camera
from glcloth.geometry.mesh import build_mesh
from glcloth.light.environment import Environment
from glcloth.light.lights import Lights, SphericalGaussians, Suns
from glcloth.picture.frame import Cloth

SIZE = (32, 24)
# A square that floats a metre above the ground, seen from straight above; it hides the sun and a part of the sky.
HALF = 0.5
SHEET = build_mesh(
    "sheet",
    np.array([[-HALF, 1, -HALF], [HALF, 1, -HALF], [HALF, 1, HALF], [-HALF, 1, HALF]]),
    np.array([[0, 2, 1], [0, 3, 2]]),
)
SUN = np.array([2.0, 2.0, 0.0]) / 8**0.5  # the shadow lies a metre to the left
LOOK = {
    "mesh": SHEET,
    "size": SIZE,
    "camera": Camera((-1.6, 8, 0.01), (-1.6, 0, 0), (0, 0, -1), fov_deg=40),
    "quality": "draft",
}


def lights(sun, sky, omega=SUN):
    gaussians = SphericalGaussians(np.array([[0.0, 1, 0]]), np.array([0.01]), np.full((1, 3), sky))
    return Lights(gaussians, Suns(np.asarray(omega)[None], np.full((1, 3), sun)))


def places(size=SIZE):
    """x and z of the ground that pixels see [H, W], of the height 0."""
    camera = LOOK["camera"]
    y, x = np.mgrid[: size[1], : size[0]][:, ::-1] + 0.5
    at = np.stack([x, y, np.ones_like(x)], -1)
    d = at @ camera.ray_from_pixel(size).T
    p = np.array(camera.eye) + d * (-camera.eye[1] / d[..., 1:2])
    return p[..., 0], p[..., 2]


@pytest.mark.parametrize("method", ["direct", "reference", "path"])
def test_its_alpha_is_the_share_of_light_that_is_hidden(renderer, method):
    """The ground is at the height 0: a square of sun's shadow, black in the sun's share of the light."""
    look = {**LOOK, "ground": "catcher", "lights": lights(3.0, 1e-3), "method": method, "cube": 4, "background": False}
    look["spp"] = 16 if method == "path" else 1
    # `catcher` lies just under the lowest point, so a second, tiny sheet stands on the ground far away.
    foot = build_mesh("foot", np.array([[9.0, 0.004, 9], [9.01, 0.004, 9], [9, 0.004, 9.01]]), np.array([[0, 2, 1]]))
    del look["mesh"]
    linen = load_fabric("linen")
    both = build_mesh(
        "both",
        np.concatenate([SHEET.positions, foot.positions]),
        np.concatenate([SHEET.triangles, foot.triangles + 4]),
    )
    picture = renderer.render(cloths=[Cloth(both, linen)], **look)
    x, z = places()
    shadow = (np.abs(x + 1) < 0.4) & (np.abs(z) < 0.4)
    sheet = (np.abs(x * 7 / 8 - 0.2) < 0.7) & (np.abs(z) < 0.8)
    lit = ((np.abs(x + 1) > 0.65) | (np.abs(z) > 0.65)) & ~sheet & (np.hypot(x, z) < 4)
    assert shadow.sum() > 5 and lit.sum() > 50
    assert picture[shadow][:, 3].min() > 0.95 and picture[lit][:, 3].max() < 0.05
    assert not picture[shadow | lit][:, :3].any(), "nothing but shadow"
    even = Environment.from_array(np.full((8, 16, 3), 0.25))
    over = renderer.render(cloths=[Cloth(both, linen)], environment=even, **{**look, "background": True})
    np.testing.assert_allclose(over[shadow | lit], 0.25 * (1 - picture[shadow | lit][:, 3:].repeat(3, 1)), atol=1e-5)


def test_it_fades_out_and_ends_nowhere(renderer):
    """A wall of a metre in a low sun: its shadow of six metres fades from 1.5 to 4; at the horizon there is no line."""
    x = np.array([[-HALF, 0, 0], [HALF, 0, 0], [HALF, 1, 0], [-HALF, 1, 0]])
    wall = build_mesh("wall", x, np.array([[0, 1, 2], [0, 2, 3]]))
    light = lights(1.0, 1e-6, np.array([0.0, 1, -6]) / 37**0.5)
    look = {"mesh": wall, "size": SIZE, "quality": "draft", "lights": light, "background": False}
    look["camera"] = Camera((0, 1.4, 9), (0, 0.9, 0), fov_deg=30)
    layers = renderer.render(**look, ground="catcher", aovs="cryptomatte,depth,mask")
    catcher = layers["beauty"][..., 3]
    y = np.arange(SIZE[1])[::-1] + 0.5
    d = np.stack([np.full_like(y, SIZE[0] / 2), y, np.ones_like(y)], -1) @ look["camera"].ray_from_pixel(SIZE).T
    horizon = np.flatnonzero(d[:, 1] < 0)[0]
    assert 0 < horizon < SIZE[1] // 2 and catcher[horizon - 1 : horizon + 2, [0, -1]].max() < 1e-3
    z = 9 - d[:, 2] * 1.4 / d[:, 1]
    alpha = catcher[:, SIZE[0] // 2]
    before, after = (z > 0.2) & (z < 1.4) & (d[:, 1] < 0), (z > 4.1) & (z < 5.5) & (d[:, 1] < 0)
    assert before.any() and after.any() and alpha[before].min() > 0.9 and alpha[after].max() < 1e-3
    between = (z > 1.6) & (z < 3.9) & (d[:, 1] < 0)
    t = (z[between] - 1.5) / 2.5
    np.testing.assert_allclose(alpha[between], 1 - t * t * (3 - 2 * t), atol=0.03)
    assert layers.names["CryptoObject"] == ["wall"] and ((layers["depth"] < 1e9) == (layers["mask"] > 0)).all()
