"""Threads and hairs by method `path`: those of the other methods, with the mean of the far cloth."""

from dataclasses import replace

import numpy as np
import pytest

from glcloth.fabric import load_fabric
from glcloth.geometry.camera import Camera
from glcloth.geometry.mesh import build_mesh
from glcloth.light.lights import Lights, SphericalGaussians, Suns
from glcloth.methods.weave_maps import fabric_maps, repeat_of
from glcloth.picture.frame import Cloth
from glcloth.picture.prints import Print, texel_means
from glcloth.twins.sheet import T_straight

SUN = Lights(
    SphericalGaussians(np.array([[0.0, 0.0, 1.0]]), np.array([0.0]), np.ones((1, 3))),
    Suns(np.array([[0.6, 0.3, 0.74]]), np.full((1, 3), 2.0)),
)
LOOK = {"lights": SUN, "size": (48, 48), "bounce": False, "background": False}


@pytest.fixture(autouse=True)
def coarse_table(monkeypatch):
    """Of what yarns hide from the side: its own test is elsewhere."""
    monkeypatch.setattr("glcloth.methods.relief.SAMPLES", 1024)


def even(name="denim_raw", **changes):
    """A fabric whose yarns are all alike, without hairs. Nobody else has relief .9, so the coarse table is nobody else's."""
    weave = load_fabric(name).weave
    loose = weave.irregularity.changed(shift=0.0, yarn=0.0, fibre=0.0)
    return load_fabric(name).changed(
        weave=weave.changed(**{"irregularity": loose, "fuzz": 0.0, "relief": 0.9, **changes})
    )


def sheet(width, height, left=0.0, name="sheet"):
    corners = np.array([[0, 0, 0], [width, 0, 0], [width, height, 0], [0, height, 0]])
    corners = corners + np.array([left, 0, 0])
    return build_mesh(name, corners, np.array([[0, 1, 2], [0, 2, 3]]), corners[:, :2], None)


def above(middle, height, theta=0.0):
    """Parallel rays onto a place of the plane, a picture that covers so much of it down the columns."""
    toward = np.array([0.0, -np.sin(theta), np.cos(theta)])
    return Camera(
        tuple(np.array(middle) + 0.3 * toward), tuple(middle), (0.0, 1.0, 0.0), ortho=float(height * np.cos(theta))
    )


def smooth(picture):
    """Means of 3x3 pixels, without the edge."""
    return sum(np.roll(picture, (i, j), (0, 1)) for i in (-1, 0, 1) for j in (-1, 0, 1))[1:-1, 1:-1] / 9.0


def alike(a, b):
    """The same samples; rounding lets one in many choose another lobe."""
    return np.isclose(a, b, rtol=2e-3, atol=1e-4).mean() > 0.97


def test_threads_are_those_of_the_reference(renderer):
    fabric, theta = even(), 0.7
    u, v = repeat_of(fabric)
    high = round(3 * u / v / np.cos(theta)) * v
    size = (40, round(40 * high * np.cos(theta) / (3 * u)))
    look = dict(
        LOOK, mesh=sheet(6 * u, 2 * high), fabric=fabric, camera=above((3 * u, high, 0), high, theta), size=size
    )
    reference = np.asarray(renderer.render(method="reference", spp=4, cube=4, **look), float)[..., :3].mean(-1)
    near = np.asarray(renderer.render(method="path", spp=48, **look), float)[..., :3].mean(-1)
    sums = renderer.path_sums()
    far = np.asarray(renderer.render(method="path", spp=48, threads=False, **look), float)[..., :3].mean(-1)
    error = np.sqrt((sums.standard_error.astype(float) ** 2).mean())
    assert abs(near.mean() / far.mean() - 1.0) < 0.005 + 4.0 * error / np.sqrt(near.size) / far.mean()
    a, b = smooth(near), smooth(reference)
    assert b.std() / b.mean() > 0.1 and np.corrcoef(a.ravel(), b.ravel())[0, 1] > 0.94
    # The denoiser is told of threads.
    guide = smooth(sums.albedo.mean(-1) / sums.samples)
    assert np.corrcoef(guide.ravel(), b.ravel())[0, 1] > 0.6


def test_each_of_two_fabrics_shows_its_own(renderer):
    """In a picture of both and of a cloth without threads, side by side, each is what it is alone, and so is the noise."""
    cloths = [
        Cloth(sheet(0.006, 0.006), even()),
        Cloth(sheet(0.006, 0.006, 0.006, "other"), even().dyed((4.0, 2.0, 0.5))),
        Cloth(sheet(0.006, 0.006, 0.012, "plain"), load_fabric("denim_raw").changed(weave=None)),
    ]
    look = dict(LOOK, method="path", spp=16, camera=above((0.009, 0.003, 0), 0.006), size=(72, 24))
    pictures, errors = [], []
    for worn in (cloths, *([cloth] for cloth in cloths)):
        pictures.append(np.asarray(renderer.render(cloths=worn, **look), float))
        errors.append(renderer.path_sums().standard_error)
    for k, part in enumerate((slice(1, 23), slice(25, 47), slice(49, 71)), 1):
        deviation = pictures[k][2:-2, part, :3].std() / pictures[k][2:-2, part, :3].mean()
        assert deviation > 0.1 or k == 3
        assert alike(pictures[0][2:-2, part], pictures[k][2:-2, part])
        assert alike(errors[0][2:-2, part], errors[k][2:-2, part])


def test_holes_are_where_the_weave_has_them(renderer):
    lace = even("lace", relief=0.0)
    u, v = repeat_of(lace)
    look = dict(LOOK, camera=above((u, v, 0), v), size=(32, round(32 * v / u)))
    behind = Lights(SUN.gaussians, Suns(SUN.suns.direction * [1.0, 1.0, -1.0], SUN.suns.irradiance))
    front, back = (
        np.asarray(
            renderer.render(mesh=sheet(2 * u, 2 * v), fabric=lace, method="path", spp=32, **(look | {"lights": lit})),
            float,
        )
        for lit in (SUN, behind)
    )
    cover = front[..., 3]
    height, width = 8 * np.array(cover.shape)
    at = np.stack(np.meshgrid((np.arange(width) + 0.5) / width + 0.5, 1.5 - (np.arange(height) + 0.5) / height), -1)
    hole = texel_means(fabric_maps(lace).hole[..., None].astype(float), at)[..., 0]
    hole = hole.reshape(height // 8, 8, width // 8, 8).mean((1, 3))
    assert np.corrcoef(smooth(cover).ravel(), smooth(hole).ravel())[0, 1] < -0.95
    # No yarn there scatters light or mirrors it.
    within = cover < 0.02
    assert within.sum() > 5
    for picture in (front, back):
        assert picture[within, :3].mean() < 0.03 * picture[..., :3].mean()
    t = lace.transmission
    far = 1.0 - T_straight(np.array([0.0, 0, 1]), t.k_a, t.k_t, np.array(t.tau), t.rho, t.diffuse).mean()
    assert abs(cover.mean() - far) < 0.015


def test_prints_colour_threads(renderer):
    """Where a print has one colour, its threads are those of the fabric dyed in it."""
    color = (1.0, 0.4, 0.2)
    halves = Print(np.array([[color, color, (1.0, 1.0, 1.0), (1.0, 1.0, 1.0)]], np.float32), (0.012, 0.012), True)
    look = dict(LOOK, method="path", spp=8, camera=above((0.006, 0.006, 0), 0.006))
    mesh = sheet(0.012, 0.012)
    printed = np.asarray(renderer.render(cloths=[Cloth(mesh, even(), halves)], **look), float)[..., :3]
    for fabric, part in ((even().dyed(color), slice(0, 11)), (even(), slice(37, 48))):
        alone = np.asarray(renderer.render(cloths=[Cloth(mesh, fabric)], **look), float)[..., :3]
        assert alike(printed[:, part], alone[:, part])


def test_far_cloth_keeps_its_bits(renderer):
    look = dict(LOOK, mesh=sheet(2.0, 2.0), fabric="denim_raw", camera=above((1, 1, 0), 1.0), size=(16, 12))
    pictures = [np.asarray(renderer.render(method="path", spp=4, threads=threads, **look)) for threads in (True, False)]
    assert np.array_equal(*pictures)


def test_hairs_are_those_of_direct(renderer):
    fabric = even(fuzz=12.0, relief=0.0)
    flat = renderer.prepare(
        mesh=sheet(0.2, 0.1), fabric=fabric, camera=Camera((0.1, 0.1, 0.4), (0.1, 0.1, 0.0), fov_deg=3.2), lights=SUN,
        size=(100, 75), background=False, method="path", spp=4,
    )  # fmt: skip
    path = renderer.render_frame(flat)
    target = renderer.ctx.simple_framebuffer((100, 75), 4, dtype="f4")
    for _ in renderer.path_steps(flat, target, lambda: 0.1):
        pass
    shown = np.frombuffer(target.read(components=4, dtype="f4"), "f4").reshape(75, 100, 4)[::-1]
    assert np.array_equal(shown, path)
    scene = flat.scene.model_copy(update={"method": "direct", "spp": 1})
    direct = renderer.render_frame(replace(flat, scene=scene))
    beyond = slice(26, 36)
    assert 0.002 < direct[beyond, :, 3].mean() < 0.3
    np.testing.assert_allclose(path[beyond], direct[beyond], atol=1e-5)
    without = renderer.render_frame(replace(flat, scene=flat.scene.model_copy(update={"threads": False})))
    assert without[beyond, :, 3].max() == 0.0
    # Hairs have the colours of a print: those of a fabric dyed in what it is where they grow.
    color, white = (1.0, 0.3, 0.1), (1.0, 1.0, 1.0)
    half = Print(np.repeat(np.array([[color, white]], np.float32), 32, 1), (0.2, 0.2), False)
    worn = Cloth(flat.mesh, fabric, half), Cloth(flat.mesh, fabric.dyed(color))
    printed, dyed = (renderer.render_frame(replace(flat, scene=scene, cloths=(one,)))[beyond] for one in worn)
    assert direct[beyond, :, 2].sum() > 1.2 * dyed[..., 2].sum()
    there = dyed[..., 3] > 0.0
    hues = [picture[..., 1:3] / np.maximum(picture[..., :1], 1e-9) for picture in (printed, dyed, direct[beyond])]
    for part, same, other in ((np.arange(100) < 40, hues[1], hues[2]), (np.arange(100) >= 60, hues[2], hues[1])):
        part = there & part
        assert part.sum() > 2 and alike(hues[0][part], same[part]) and not alike(hues[0][part], other[part])
    target.release()
