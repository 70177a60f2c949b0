"""Objects with pictures, roughness and metalness: GGX over Lambertians, by methods direct and reference."""

import io
from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

from glcloth.color import srgb_decode
from glcloth.errors import InputError
from glcloth.geometry.camera import Camera
from glcloth.geometry.mesh_files import load_mesh, load_object
from glcloth.geometry.placing import placed
from glcloth.geometry.props import Objects
from glcloth.geometry.raw import Material
from glcloth.gpu.pictures import even_size, picture_array, resampled
from glcloth.light.environment import Environment
from glcloth.light.lights import Lights, SphericalGaussians, Suns
from glcloth.twins.gloss import f_gloss, gloss_albedo

AWAY = placed(load_mesh("plane"), 1.0, 0.0, (0.0, 0.0, -50.0))  # the cloth, out of sight
EVEN = SphericalGaussians(np.array([[0.0, 1.0, 0.0]]), np.array([1e-4]), np.ones((1, 3)))
BROAD = SphericalGaussians(
    np.array([[0.48, 0.6, 0.64], [-0.6, 0.48, 0.64]]),
    np.array([6.0, 40.0]),
    np.array([[1.0, 0.9, 0.8], [2.0, 2.5, 3.0]]),
)
NARROW = SphericalGaussians(BROAD.axis, np.array([100.0, 200.0]), BROAD.amplitude)
WHITE = (1.0, 1.0, 1.0)
CAMERA = Camera((0.0, 0.0, 2.2), (0.0, 0.0, 0.0), fov_deg=32.0)


def ball(*materials, material_of=None):
    mesh = load_mesh("sphere")
    numbers = np.zeros(len(mesh.triangles), np.int32) if material_of is None else material_of
    colors = np.array([m.color for m in materials], np.float32)[numbers]
    return Objects((mesh,), (colors,), materials=(materials,), material_of=(numbers,))


def picture(renderer, objects, lights=EVEN, **changes):
    """[H, W, 4]"""
    changes = {"method": "direct", "shadows": "off", "size": (48, 48), "env": "studio", "camera": CAMERA, **changes}
    return renderer.render(mesh=AWAY, objects=objects, lights=lights, background=False, **changes).copy()


@pytest.mark.parametrize("method", ["direct", "reference"])
@pytest.mark.parametrize("roughness", [0.1, 0.5, 1.0])
def test_a_white_metal_keeps_even_light(renderer, method, roughness):
    """What one reflection loses the next ones give back, so that it cannot be told from its surroundings."""
    shown = picture(renderer, ball(Material("m", WHITE, roughness, 1.0)), method=method, cube=24)
    whole = shown[..., 3] == 1.0
    far_off = np.abs(shown[..., :3] - 1.0)
    # But for the rim.
    inside = whole[1:-1, 1:-1] & whole[:-2, 1:-1] & whole[2:, 1:-1] & whole[1:-1, :-2] & whole[1:-1, 2:]
    assert inside.sum() > 1000 and far_off[1:-1, 1:-1][inside].max() < 0.02
    assert far_off[whole].max() < 0.04 and np.quantile(far_off[whole], 0.99) < 0.02


@pytest.mark.parametrize("turn", [0.0, 30.0])
def test_a_white_metal_keeps_even_light_of_a_map(renderer, turn):
    """A lobe narrower than the map's texels is summed within them, whichever way they are turned."""
    even = Environment.from_array(np.ones((16, 32, 3), np.float32))
    shown = picture(renderer, ball(Material("m", WHITE, 0.1, 1.0)), None, method="reference", light="map", environment=even,
                    env_rotate=turn, cube=24)  # fmt: skip
    far_off = np.abs(shown[shown[..., 3] == 1.0][:, :3] - 1.0)
    assert len(far_off) > 1000 and far_off.max() < 0.05 and np.quantile(far_off, 0.99) < 0.02


@pytest.mark.parametrize("alpha", [0.1, 0.3, 1.0])
def test_what_a_rough_surface_gives_back_is_the_integral_of_its_gloss(alpha):
    """The share found over normals is that found over directions."""
    cos_theta, weight = np.polynomial.legendre.leggauss(400)
    cos_theta, weight = 0.5 * cos_theta + 0.5, 0.5 * weight
    phi = np.pi * (np.arange(400) + 0.5) / 400
    c, p = (a.ravel() for a in np.meshgrid(cos_theta, phi))
    omega_i = np.stack([-np.sqrt(1 - c**2) * np.cos(p), np.sqrt(1 - c**2) * np.sin(p), c], -1)
    up, cos_o = np.array([0.0, 0.0, 1.0]), np.array([0.3, 0.8])
    for cosine, found in zip(cos_o, gloss_albedo(cos_o, np.full(2, alpha), 200), strict=True):
        omega_o = np.array([np.sqrt(1 - cosine**2), 0.0, cosine])
        f = f_gloss(up, omega_i, omega_o, np.ones(3), alpha)[:, 0].reshape(400, 400)
        assert (f * weight).sum() * 2.0 * np.pi / 400 == pytest.approx(found, rel=0.02)


@pytest.mark.parametrize(
    ("material", "lights", "far"),
    [
        ((0.5, 0.0), BROAD, 0.02),
        ((0.35, 1.0), BROAD, 0.08),
        ((0.6, 1.0), BROAD, 0.06),
        ((0.8, 1.0), BROAD, 0.06),
        ((0.6, 1.0), NARROW, 0.06),
        ((1.0, 1.0), NARROW, 0.06),
    ],
)
def test_gloss_under_gaussians_is_that_of_a_sum_over_directions(renderer, material, lights, far):
    objects = ball(Material("m", (0.8, 0.5, 0.3), *material))
    direct, reference = (picture(renderer, objects, lights, method=name, cube=32) for name in ("direct", "reference"))
    seen = direct[..., 3] > 0
    assert seen.sum() > 600
    error = np.abs(direct - reference)[seen][:, :3].mean() / reference[seen][:, :3].mean()
    assert error < far, error


def test_a_sun_is_mirrored_where_it_should_be(renderer):
    sun = np.array([0.6, 0.0, 0.8])
    lights = Lights(replace_amplitude(EVEN, 1e-6), Suns(sun[None], np.ones((1, 3))))
    shown = picture(renderer, ball(Material("m", WHITE, 0.3, 1.0)), lights, camera=CAMERA, size=(96, 96))
    row, column = np.unravel_index(shown[..., 1].argmax(), (96, 96))
    # The normal half way between sun and viewer, where the ray through that pixel meets the ball.
    ray = CAMERA.ray_from_pixel((96, 96)) @ (column + 0.5, 95.5 - row, 1.0)
    ray /= np.linalg.norm(ray)
    eye = np.array(CAMERA.eye)
    b = eye @ ray
    N = (eye + ray * (-b - np.sqrt(b * b - eye @ eye + 0.25))) / 0.5
    h = sun - ray
    assert N @ h / np.linalg.norm(h) > np.cos(np.radians(2.5))


def replace_amplitude(gaussians, factor):
    return SphericalGaussians(gaussians.axis, gaussians.sharpness, factor * gaussians.amplitude)


def test_a_picture_lies_on_the_ball_the_right_way_up(renderer):
    """Above yellow, below red on the left (small u), blue on the right; colours are decoded, and times the material's."""
    codes = np.zeros((64, 128, 3), np.uint8)
    codes[:32], codes[32:, :64], codes[32:, 64:] = (230, 200, 30), (200, 40, 40), (30, 60, 200)
    blob = io.BytesIO()
    Image.fromarray(codes).save(blob, "PNG")
    mesh = load_mesh("sphere")
    mesh = replace(mesh, uv=mesh.uv / mesh.uv.max(0))
    objects = Objects(
        (mesh,), (np.ones((len(mesh.triangles), 3), np.float32),),
        materials=((Material("m", (0.5, 1.0, 1.0), 1.0, 0.0, blob.getvalue()),),),
        material_of=(np.zeros(len(mesh.triangles), np.int32),),
    )  # fmt: skip
    shown = picture(renderer, objects, camera=Camera((0.0, 0.0, -2.2), (0.0, 0.0, 0.0), fov_deg=32.0))
    for place, code in (((14, 24), codes[0, 0]), ((34, 14), codes[40, 0]), ((34, 34), codes[40, 100])):
        wanted = srgb_decode(code / 255.0) * (0.5, 1.0, 1.0)
        assert shown[place][:3] == pytest.approx(wanted, rel=0.02, abs=0.004), place


def test_each_object_has_its_own_picture(renderer):
    """Two balls side by side whose pictures differ: neither shows the other's, nor the material of one that has none."""
    balls, codes = [], ((220, 40, 40), (40, 60, 220), (90, 90, 90))
    for number in range(3):
        blob = io.BytesIO()
        Image.fromarray(np.full((8, 8 << number, 3), codes[number], np.uint8)).save(blob, "PNG")
        picture_of = blob.getvalue() if number < 2 else None
        balls.append((placed(load_mesh("sphere"), 0.5, 0.0, (0.6 * number - 0.6, 0.0, 0.0)), picture_of))
    objects = Objects(
        tuple(mesh for mesh, _ in balls), (np.ones((len(balls[0][0].triangles), 3), np.float32),) * 3,
        materials=tuple((Material(f"m{n}", WHITE, 1.0, 0.0, blob),) for n, (_, blob) in enumerate(balls)),
        material_of=(np.zeros(len(balls[0][0].triangles), np.int32),) * 3,
    )  # fmt: skip
    shown = picture(renderer, objects, camera=Camera((0.0, 0.0, 3.2), (0.0, 0.0, 0.0), fov_deg=32.0))
    for column, wanted in ((8, srgb_decode(np.array(codes[0]) / 255.0)), (24, srgb_decode(np.array(codes[1]) / 255.0))):
        assert shown[24, column, :3] == pytest.approx(wanted, rel=0.03, abs=0.004)
    assert shown[24, 40, :3] == pytest.approx((1.0, 1.0, 1.0), rel=0.03)


def test_matt_objects_have_the_bits_they_had(renderer):
    """A material that says nothing but a colour is shaded as a colour, whatever program the others need."""
    plain = ball(Material("a", (0.3, 0.4, 0.5)))
    bare = Objects(plain.meshes, plain.reflectances)
    assert np.array_equal(picture(renderer, plain, BROAD), picture(renderer, bare, BROAD))
    half = (np.arange(len(plain.meshes[0].triangles)) % 2).astype(np.int32)
    both = ball(Material("a", (0.3, 0.4, 0.5)), Material("b", (0.3, 0.4, 0.5), 0.3), material_of=half)
    shown, matt = picture(renderer, both, BROAD), picture(renderer, bare, BROAD)
    same = np.isclose(shown, matt, rtol=1e-5).all(-1)[matt[..., 3] > 0]
    assert 0.3 < same.mean() < 0.7


@pytest.mark.parametrize("name", ["red.png", "red.bmp"])
def test_an_obj_and_its_picture_make_an_object(tmp_path, name):
    Image.fromarray(np.full((4, 4, 3), (255, 0, 0), np.uint8)).save(tmp_path / name)
    look = "newmtl m\nKd 0.5 1 1\nPr 0.4\nPm 0.25\nmap_Kd {}\nnewmtl n\nKd 0.1 0.2 0.3\n"
    (tmp_path / "a.mtl").write_text(look.format(name))
    (tmp_path / "a.obj").write_text(
        "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nvt 0 0\nvt 1 0\nvt 0 1\n"
        "usemtl n\nf 1/1 2/2 3/3\nusemtl m\nf 2/1 4/2 3/3\n"
    )
    _, colors, materials, material_of = load_object(tmp_path / "a.obj")
    assert [(m.name, m.roughness, m.metalness) for m in materials] == [("n", 1.0, 0.0), ("m", 0.4, 0.25)]
    assert material_of.tolist() == [0, 1] and np.allclose(colors, [[0.1, 0.2, 0.3], [0.5, 0.0, 0.0]], atol=1e-6)


def test_a_picture_of_another_size_keeps_its_mean():
    image = np.random.default_rng(1).random((37, 90, 3)).astype(np.float32)
    assert even_size(37, 90) == (64, 128) and even_size(3000, 5000, 1 << 22) == (2048, 2048)
    for size in ((64, 128), (32, 64), (8, 128)):
        assert resampled(image, size).shape == (*size, 3)
        assert resampled(image, size).mean((0, 1)) == pytest.approx(image.mean((0, 1)), rel=1e-5)
    assert np.array_equal(resampled(image[:32, :64], (32, 64)), image[:32, :64])


def test_more_pictures_than_the_device_takes_are_refused(ctx):
    most = ctx.info["GL_MAX_ARRAY_TEXTURE_LAYERS"]
    picture_array(ctx, np.zeros((3, 1, 1, 3), "f4")).release()
    with pytest.raises(InputError, match=f"{most + 1} different pictures .* at most {most}"):
        picture_array(ctx, np.zeros((most + 1, 1, 1, 3), "f4"))
