"""Method `reference`, the judge: against golden values, and pixel by pixel against the float64 twin."""

import numpy as np
import pytest
from golden import golden_samples, luminance_errors
from test_truth import model

from glcloth.fabric import load_fabric
from glcloth.geometry.camera import Camera
from glcloth.light.environment import Environment, cube_map_of_gaussians
from glcloth.light.lights import Lights, SphericalGaussians, Suns
from glcloth.twins import cloth

LIGHTS = Lights(
    SphericalGaussians([[0, 1, 0], [0.6, 0.3, 0.7]], [2.0, 20.0], [[0.5, 0.6, 0.8], [3.0, 2.5, 2.0]]),
    Suns([[-0.5, 0.6, 0.6]], [[1.0, 0.9, 0.7]]),
)


@pytest.mark.parametrize("normalization", ["sadeghi", "paper"])
def test_golden(renderer, shared, normalization):
    """At most 0.5 % (median) and 2 % (95th percentile) with the 6 x 32 x 32 directions of the paper."""
    errors = []
    for fabric, omega_o, lights, expected in golden_samples(shared, normalization):
        got = renderer.radiance(fabric, omega_o, lights, method="reference")
        errors.append(luminance_errors(got, expected))
    errors = np.concatenate(errors)
    assert np.median(errors) <= 0.005 and np.percentile(errors, 95) <= 0.02


@pytest.mark.parametrize("name", ["linen", "velvet"])
def test_a_picture_is_the_twin_at_every_pixel(renderer, name):
    """Frames, rays, handedness, suns and the sum over the cube map, by an independent path in float64."""
    size, cube = (24, 18), 8
    camera = Camera((0.3, 0.6, 2.2), (0, 0, 0))
    fabric = load_fabric(name)
    picture = renderer.render(
        fabric=fabric,
        mesh="sphere",
        lights=LIGHTS,
        camera=camera,
        method="reference",
        shadows="off",
        cube=cube,
        size=size,
        background=False,
    )
    buffer = renderer.gbuffer
    N, x = (
        np.frombuffer(t.read(), "f4").reshape(size[1], size[0], 4).astype(float)
        for t in map(buffer.frame, ("frame_N", "frame_x"))
    )
    omega, solid_angle, radiance = cube_map_of_gaussians(LIGHTS.gaussians, cube)
    omega = np.concatenate([omega, LIGHTS.suns.direction])
    flux = np.concatenate([radiance * solid_angle[:, None], LIGHTS.suns.irradiance])
    checked = 0
    for row, column in np.argwhere(N[..., 3] != 0)[::7]:
        n, t = N[row, column, :3], x[row, column, :3]
        frame = np.stack([t, N[row, column, 3] * np.cross(n, t), n])
        ray = buffer.ray_from_pixel @ [column + 0.5, row + 0.5, 1.0]
        omega_o = frame @ (-ray / np.linalg.norm(ray))
        expected = cloth.L_o(omega_o[None], omega @ frame.T, flux, *model(fabric))[0]
        assert picture[size[1] - 1 - row, column, :3] == pytest.approx(expected, rel=2e-3, abs=1e-5)
        checked += 1
    assert checked > 10


def test_the_map_and_its_gaussians_give_the_same_picture(renderer):
    """An environment that is a spherical Gaussian, lit as a map and as that Gaussian, turned by the same angle."""
    from glcloth.light.environment import direction_from_uv, rotation_y

    gaussians = SphericalGaussians([[0.3, 0.5, 0.8]], [6.0], [[1.0, 2.0, 3.0]])
    v, u = np.meshgrid((np.arange(128) + 0.5) / 128, (np.arange(256) + 0.5) / 256, indexing="ij")
    environment = Environment("gaussian", gaussians.radiance(direction_from_uv(u, v)))
    scene = dict(
        mesh="sphere",
        environment=environment,
        method="reference",
        shadows="off",
        cube=16,
        size=(24, 18),
        background=False,
    )
    by_map = renderer.render(**scene, light="map", env_rotate=50.0)
    by_lobe = renderer.render(**scene, lights=gaussians.rotated(rotation_y(50.0)))
    assert np.abs(by_map - by_lobe).max() < 0.01 * by_lobe.max()


def test_radiance_is_black_below_the_surface(renderer):
    got = renderer.radiance("linen", [[0, 0, -1], [0.6, 0, -0.8], [0, 0, 1]], LIGHTS, method="reference", cube=8)
    assert not got[:2].any() and got[2].min() > 0
