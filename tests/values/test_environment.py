"""Environments: orientation, energy, cube maps, the built-in ones, and wrong maps."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from glcloth.color import luminance
from glcloth.errors import InputError
from glcloth.image import write_image
from glcloth.light import cubemap, environment, equirect, skies
from glcloth.light.environment import (
    Environment,
    cube_directions,
    cube_map,
    cube_map_of_gaussians,
    direction_from_uv,
    load_environment,
    lookup,
    rotation_y,
    uv_from_direction,
)
from glcloth.light.harmonics import gaussian_flux
from glcloth.light.lights import Lights, SphericalGaussians, Suns


@pytest.fixture
def warnings_said(monkeypatch):
    said = []
    monkeypatch.setattr(environment, "warn", said.append)
    return said


def random_directions(n, seed=0):
    omega = np.random.default_rng(seed).normal(size=(n, 3))
    return omega / np.linalg.norm(omega, axis=-1, keepdims=True)


def test_uv_and_direction_are_inverse():
    omega = random_directions(5000)
    assert np.abs(direction_from_uv(*uv_from_direction(omega)) - omega).max() < 1e-14
    u, v = np.random.default_rng(1).random((2, 5000))
    u_back, v_back = uv_from_direction(direction_from_uv(u, v))
    assert np.abs(v_back - v).max() < 1e-14
    # Near a pole longitude is ill-conditioned by 1 / sin(theta).
    distance = np.abs(u_back - u)
    assert (np.minimum(distance, 1 - distance) * np.sin(np.pi * v)).max() < 1e-14


def test_orientation_is_mitsubas():
    """Mitsuba 3, src/emitters/envmap.cpp: u = atan2(x, -z) / 2 pi, v = acos(y) / pi."""
    cases = {(0, 0, -1): (0, 0.5), (1, 0, 0): (0.25, 0.5), (0, 0, 1): (0.5, 0.5), (-1, 0, 0): (0.75, 0.5)}
    for direction, uv in cases.items():
        assert np.allclose(uv_from_direction(np.array(direction, float)), uv)
        assert np.allclose(direction_from_uv(*uv), direction)
    assert uv_from_direction(np.array([0.0, 1, 0]))[1] == 0 and uv_from_direction(np.array([0.0, -1, 0]))[1] == 1
    assert uv_from_direction(np.array([-1e-30, 0, -1]))[0] == 0, "u stays below 1"


def test_positive_rotation_is_counter_clockwise_from_above():
    """Seen from above with +x to the right, +z points down the page; counter-clockwise takes it to the right."""
    assert np.allclose(rotation_y(90) @ [0, 0, 1], [1, 0, 0])
    for degrees in (-725.0, 0.0, 33.0, 180.0):
        expected = Rotation.from_euler("y", degrees, degrees=True).as_matrix()
        assert np.allclose(rotation_y(degrees), expected, atol=1e-14)
    assert np.array_equal(rotation_y(360), np.eye(3))


def test_solid_angles_fill_the_sphere():
    assert equirect.row_solid_angles(7, 5).sum() * 5 == pytest.approx(4 * np.pi, rel=1e-14)
    assert cubemap.solid_angles(9).sum() == pytest.approx(4 * np.pi, rel=1e-13)
    # Against quadrature of dA / (1 + s^2 + t^2)^(3/2) over each texel of one face.
    x, w = np.polynomial.legendre.leggauss(12)
    edges = np.linspace(-1, 1, 10)
    centre, half = (edges[1:] + edges[:-1]) / 2, 1 / 9
    s = centre[:, None] + half * x
    value = (1 + s[:, None, :, None] ** 2 + s[None, :, None, :] ** 2) ** -1.5
    expected = np.einsum("abij,i,j->ab", value, w, w) * half * half
    assert np.allclose(cubemap.solid_angles(9)[:81].reshape(9, 9), expected, rtol=1e-12)


@pytest.mark.parametrize("shape", [(30, 60), (64, 100), (33, 71)])
@pytest.mark.parametrize("target", [(16, 32), (10, 17)])
def test_downsample_keeps_the_integral(shape, target):
    radiance = np.random.default_rng(2).random((*shape, 3)).astype(np.float32)
    coarse = equirect.downsample(radiance, *target)
    assert coarse.shape == (*target, 3)
    assert np.allclose(equirect.total(coarse), equirect.total(radiance), rtol=1e-12)
    assert np.allclose(equirect.downsample(np.ones((*shape, 3)), *target), 1)


def test_downsample_is_the_average_over_each_texel():
    radiance = np.random.default_rng(3).random((8, 16, 1))
    weight = np.repeat(equirect.row_solid_angles(8, 16)[:, None], 16, 1)
    expected = [
        [
            np.average(
                radiance[2 * r : 2 * r + 2, 4 * c : 4 * c + 4, 0], weights=weight[2 * r : 2 * r + 2, 4 * c : 4 * c + 4]
            )
            for c in range(4)
        ]
        for r in range(4)
    ]
    assert np.allclose(equirect.downsample(radiance, 4, 4)[..., 0], expected)


def test_lookup_is_bilinear_and_wraps():
    height, width = 12, 24
    rng = np.random.default_rng(4)
    e = Environment("random", rng.random((height, width, 3)))
    centres = equirect.texel_directions(height, width)
    assert np.allclose(lookup(e, centres), e.radiance, atol=1e-6)
    seam = direction_from_uv(np.array(0.0), np.array(5.5 / height))
    assert np.allclose(lookup(e, seam), (e.radiance[5, 0] + e.radiance[5, -1]) / 2, atol=1e-6)
    # Over the zenith the two texels of opposite longitude meet.
    pole = lookup(e, direction_from_uv(np.array(3.5 / width), np.array(1e-9)))
    assert np.allclose(pole, (e.radiance[0, 3] + e.radiance[0, 3 + width // 2]) / 2, atol=1e-5)
    ramp = equirect.texel_directions(256, 512)
    smooth = Environment("smooth", ramp * 0.5 + 0.5)
    omega = random_directions(2000, 5)
    assert np.abs(lookup(smooth, omega) - (omega * 0.5 + 0.5)).max() < 1e-4


def test_cube_directions_and_texels_agree():
    n = 8
    omega = cube_directions(n)
    assert np.allclose(np.linalg.norm(omega, axis=-1), 1)
    assert np.array_equal(cubemap.texel_of(omega, n), np.arange(6 * n * n))
    # OpenGL's order of faces; the first texel of each is the corner s = t = -1 of table 8.19.
    corners = {0: (1, 1, 1), 1: (-1, 1, -1), 2: (-1, 1, -1), 3: (-1, -1, 1), 4: (-1, 1, 1), 5: (1, 1, -1)}
    for face, corner in corners.items():
        assert np.array_equal(np.sign(omega[face * n * n]), corner)
    # Moments of the cube's directions over the sphere: 0, and 1/3 on the diagonal.
    weight = cubemap.solid_angles(32)
    big = cube_directions(32)
    assert np.abs(weight @ big).max() < 1e-12
    assert np.allclose((big * weight[:, None]).T @ big, np.eye(3) * 4 * np.pi / 3, atol=1e-10)


@pytest.mark.parametrize("shape", [(4, 8), (50, 100), (256, 512), (520, 1040)])
def test_cube_map_keeps_the_energy(shape):
    rng = np.random.default_rng(6)
    radiance = rng.random((*shape, 3)).astype(np.float32) * [1, 0.5, 0]
    radiance[shape[0] // 3, shape[1] // 5] = [3e4, 2e4, 1e3]
    e = Environment("lamp", radiance)
    omega, solid_angle, cube = cube_map(e, 16)
    assert omega.shape == (1536, 3) and np.all(cube >= 0)
    assert np.allclose(solid_angle @ cube, equirect.total(e.radiance), rtol=1e-12)


def test_cube_map_of_constant_and_of_smooth_maps():
    constant = Environment("constant", np.full((200, 400, 3), 0.7))
    assert np.allclose(cube_map(constant, 32)[2], np.float32(0.7), rtol=1e-6)
    smooth = Environment("smooth", equirect.texel_directions(512, 1024) + 1)
    omega, _, cube = cube_map(smooth, 16)
    # A linear function averages to its value at the centroid; the map's texels (0.006 rad) decide where a texel ends.
    assert np.abs(cube - (omega + 1)).max() < 0.006


def test_cube_map_puts_a_lamp_in_its_place():
    radiance = np.zeros((256, 512, 3))
    radiance[70, 300] = [5, 4, 3]
    e = Environment("lamp", radiance)
    omega, solid_angle, cube = cube_map(e, 32)
    lit = np.flatnonzero(cube[:, 0])
    place = equirect.texel_directions(256, 512)[70, 300]
    assert len(lit) == 1 and np.degrees(np.arccos(omega[lit[0]] @ place)) < 2.5
    assert np.allclose(cube[lit[0]] * solid_angle[lit[0]], radiance[70, 300] * equirect.row_solid_angles(256, 512)[70])


@pytest.mark.parametrize("sharpness", [1e-12, 0.5, 20.0, 300.0, 2e3, 6e4, 1e7])
def test_cube_map_of_a_gaussian_keeps_its_integral(sharpness):
    axis = random_directions(4, 7)
    g = SphericalGaussians(axis, np.full(4, sharpness), np.random.default_rng(8).random((4, 3)))
    for n in (8, 32):
        omega, solid_angle, cube = cube_map_of_gaussians(g, n)
        flux = g.amplitude * gaussian_flux(g.sharpness)[:, None]
        assert np.allclose(solid_angle @ cube, flux.sum(0), rtol=1e-9)
        # The mean direction of a lobe stays on its axis, within a texel for the sharpest.
        one = cube_map_of_gaussians(SphericalGaussians(axis[:1], [sharpness], [[1, 1, 1]]), n)[2][:, 0]
        if sharpness > 0.1:
            mean = (solid_angle * one) @ omega
            assert np.arccos(min(mean @ axis[0] / np.linalg.norm(mean), 1)) < (0.003 if sharpness < 50 else 2**0.5 / n)


def test_cube_map_of_gaussians_is_the_texel_average():
    """Against 60 x 60 midpoints in each of a few texels near the axis."""
    n = 16
    g = SphericalGaussians([[0.3, 0.8, 0.5], [-1, 0.1, 0.2]], [400.0, 3.0], [[2, 1, 0.5], [0.1, 0.2, 0.3]])
    cube = cube_map_of_gaussians(g, n)[2]
    for texel in np.argsort(-cube[:, 0])[[0, 1, 3, 6, 300]]:
        face, row, column = texel // n**2, texel // n % n, texel % n
        x = (np.arange(60) + 0.5) / 60
        t, s = np.meshgrid((row + x) / n * 2 - 1, (column + x) / n * 2 - 1, indexing="ij")
        omega = cubemap._face_directions(s, t)[face]
        length = np.linalg.norm(omega, axis=-1)
        weight = length**-3
        expected = np.tensordot(weight, g.radiance(omega / length[..., None]), 2) / weight.sum()
        assert np.allclose(cube[texel], expected, rtol=2e-3)


def test_suns_go_to_the_texel_that_contains_them():
    suns = Suns(random_directions(5, 9), np.random.default_rng(10).random((5, 3)))
    dark = SphericalGaussians([[0, 1, 0]], [1.0], [[0, 0, 0]])
    for _, solid_angle, cube in (cube_map_of_gaussians(dark, 32, suns), cube_map_of_gaussians(Lights(dark, suns), 32)):
        assert np.allclose(solid_angle @ cube, suns.irradiance.sum(0))
        index = cubemap.texel_of(suns.direction, 32)
        assert np.allclose(cube[index] * solid_angle[index, None], suns.irradiance)
        assert np.all(np.einsum("ij,ij->i", cube_directions(32)[index], suns.direction) > np.cos(np.radians(2.6)))


@pytest.mark.parametrize("name", skies.BUILT_IN)
def test_built_in_environments(name):
    e = load_environment(name)
    assert e.radiance.shape == (512, 1024, 3) and e.radiance.dtype == np.float32
    assert np.all(np.isfinite(e.radiance)) and e.radiance.min() >= 0
    assert np.array_equal(e.radiance, skies.BUILT_IN[name]()), "made anew it is the same"
    omega = equirect.texel_directions(512, 1024)
    weight = equirect.row_solid_angles(512, 1024)
    for normal in ([0, 1, 0], [0, 0, 1]):
        irradiance = np.einsum("hwc,hw,h->c", e.radiance, np.maximum(omega @ normal, 0), weight)
        # A white card that lies, or faces the viewer, is neither black nor burnt out, and not tinted much.
        assert 0.3 < luminance(irradiance) / np.pi < 1.5
        assert irradiance.max() / irradiance.min() < 1.6


def test_sun_and_sky_have_the_size_and_strength_of_the_real_ones():
    """Solid angle 6.8e-5 sr; on a clear day the sun gives 60 to 110 klx, the sky 8 to 30 klx on level ground."""
    e = load_environment("sky")
    omega = equirect.texel_directions(512, 1024)
    weight = np.repeat(equirect.row_solid_angles(512, 1024)[:, None], 1024, 1)
    near = omega @ skies.SUN_DIRECTION > np.cos(np.radians(1))
    bright = luminance(e.radiance) > 100
    assert np.array_equal(bright, bright & near)
    Y = luminance(e.radiance.astype(float)) * skies.KILOCANDELA_PER_UNIT
    sun = float((Y * weight)[near].sum())
    assert sun == pytest.approx(luminance(skies.sun_irradiance()), rel=0.01) and 60 < sun < 110
    # sum of L / max(L) bounds the disc's solid angle from below, within the partly covered texels.
    assert float((Y * weight)[near].sum() / Y.max()) == pytest.approx(6.8e-5, rel=0.15)
    mean = np.einsum("hwc,hw->c", omega, Y * weight * near)
    assert np.degrees(np.arccos(mean @ skies.SUN_DIRECTION / np.linalg.norm(mean))) < 0.02
    sky = float((Y * weight * np.maximum(omega[..., 1], 0))[~near].sum())
    assert 8 < sky < 30


def test_sky_follows_preetham():
    """The zenith has the published zenith luminance; the sky is bluest away from the sun and brightest beside it."""
    T, theta_s = 2.8, np.arccos(skies.SUN_DIRECTION[1])
    Y_z = (4.0453 * T - 4.9710) * np.tan((4 / 9 - T / 120) * (np.pi - 2 * theta_s)) - 0.2155 * T + 2.4192
    zenith = skies.clear_sky(np.array([0.0, 1.0, 0.0]))
    assert luminance(zenith) == pytest.approx(Y_z, rel=2e-3)
    assert zenith[2] > zenith[1] > zenith[0]
    ring = direction_from_uv(
        np.linspace(0, 1, 60, endpoint=False), np.full(60, np.arccos(skies.SUN_DIRECTION[1]) / np.pi)
    )
    brightness = luminance(skies.clear_sky(ring))
    u_sun = uv_from_direction(skies.SUN_DIRECTION)[0]
    assert abs(np.argmax(brightness) / 60 - u_sun) < 1 / 60 and brightness.max() > 3 * brightness.min()


def test_black_bodies_have_their_chromaticity():
    """x, y = 0.3135, 0.3237 at 6500 K and 0.4476, 0.4074 at 2856 K (CIE 15), within the error of the fitted curves."""
    xyz_from_rgb = np.linalg.inv(skies._RGB_FROM_XYZ)
    for kelvin, x, y in ((6500, 0.3135, 0.3237), (2856, 0.4476, 0.4074)):
        XYZ = xyz_from_rgb @ skies.blackbody(kelvin)
        assert np.allclose(XYZ[:2] / XYZ.sum(), [x, y], atol=0.006)


def test_unusable_samples_give_one_warning(tmp_path, warnings_said):
    radiance = np.full((16, 32, 3), 0.5, np.float32)
    radiance[0, 0] = np.nan
    radiance[1, :2] = -3
    radiance[2, 0, 1] = np.inf
    radiance[3, 0, 1] = 7
    path = write_image(tmp_path / "odd.exr", radiance)
    e = load_environment(path)
    assert np.all(np.isfinite(e.radiance)) and e.radiance.min() == 0 and e.radiance.max() == 7
    assert e.radiance[2, 0, 1] == 7 and e.name == "odd.exr"
    assert len(warnings_said) == 1
    for part in (str(path), "3 not a number", "6 negative", "1 infinite"):
        assert part in warnings_said[0]


def test_clean_maps_are_untouched_and_silent(tmp_path, warnings_said):
    radiance = np.random.default_rng(11).random((16, 32, 3), np.float32)
    assert np.array_equal(load_environment(write_image(tmp_path / "a.exr", radiance)).radiance, radiance)
    assert warnings_said == []
    load_environment(write_image(tmp_path / "square.exr", radiance[:, :16]))
    assert len(warnings_said) == 1 and "twice as wide" in warnings_said[0]


def test_wrong_environments_are_refused(tmp_path):
    with pytest.raises(InputError, match="did you mean studio"):
        load_environment("studoi")
    with pytest.raises(InputError, match=r"unknown; give one of studio, sky"):
        load_environment("qqqq")
    with pytest.raises(InputError, match="every sample is 0"):
        load_environment(write_image(tmp_path / "black.exr", np.zeros((8, 16, 3))))
    with pytest.raises(InputError, match="no such file"):
        load_environment(tmp_path / "missing.hdr")
    (tmp_path / "notes.txt").write_text("x")
    with pytest.raises(InputError, match="as an environment"):
        load_environment(tmp_path / "notes.txt")
    with pytest.raises(InputError, match="expected a whole number from 1 to 512"):
        cube_directions(0)
    with pytest.raises(InputError, match=r"expected \[H, W, 3\]"):
        Environment("x", np.zeros((4, 8)))


def test_real_maps_load(shared, warnings_said):
    for path in sorted((shared / "assets" / "hdri").glob("*.exr")):
        e = load_environment(path)
        assert e.radiance.shape == (512, 1024, 3) and np.all(e.mean > 0)
        _, solid_angle, cube = cube_map(e, 32)
        assert np.allclose(solid_angle @ cube, equirect.total(e.radiance), rtol=1e-9)


def test_the_ground_of_the_sky_is_no_flat_grey_and_ends_in_haze():
    sky = skies.sky()
    ground = luminance(sky[skies.HEIGHT // 2 + 20 :])
    near = ground[40:120]
    assert 0.04 < near.std() / near.mean() < 0.3, "patches"
    E = luminance(np.einsum("hwc,hw,h->c", sky[:256], equirect.texel_directions(512, 1024)[:256, :, 1],
                            equirect.row_solid_angles(512, 1024)[:256]))  # fmt: skip
    assert ground.mean() * np.pi / E == pytest.approx(skies.GROUND_LUMINANCE, rel=0.1)
    rows = luminance(sky[250:280])
    assert (np.abs(np.diff(rows, axis=0)) < 0.3 * rows[:-1]).all(), "no edge at the horizon"
    assert rows[6].mean() > 1.7 * rows[-1].mean(), "haze is brighter"
