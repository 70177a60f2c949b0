"""Surfaces: a second cloth of another fabric is one more of them; each pixel belongs to the nearest."""

from dataclasses import replace

import numpy as np
import pytest

from glcloth.color import luminance
from glcloth.fabric import load_fabric
from glcloth.geometry.camera import Camera
from glcloth.geometry.mesh_files import load_mesh
from glcloth.geometry.props import Objects, stand_on
from glcloth.light.lights import Lights, SphericalGaussians, Suns
from glcloth.picture.frame import Cloth
from glcloth.twins.cloth import f_cloth
from glcloth.twins.directions import even_directions

SIZE = (132, 88)
CAMERA = Camera((0.2, 0.6, 2.3), (0.0, 0.0, -0.3), fov_deg=45.0)
LIGHTS = Lights(
    SphericalGaussians(
        np.array([[0.3, 0.9, 0.3], [-0.8, 0.5, 0.33]])
        / np.linalg.norm([[0.3, 0.9, 0.3], [-0.8, 0.5, 0.33]], axis=1)[:, None],
        np.array([3.0, 60.0]),
        np.array([[1.0, 0.9, 0.8], [3.0, 3.0, 4.0]]),
    ),
    Suns(np.array([[0.0, 0.6, 0.8]]), np.array([[2.0, 1.8, 1.5]])),
)
LINEN, SATIN = "linen", "satin_charmeuse_front"


def moved(mesh, offset):
    return replace(mesh, positions=mesh.positions + np.asarray(offset), name=f"{mesh.name} {offset}")


@pytest.fixture(scope="module")
def meshes():
    sphere = load_mesh("sphere")
    return moved(sphere, (-0.3, 0.0, 0.0)), moved(sphere, (0.3, 0.0, -0.7))


def picture(renderer, cloths, **changes):
    """The picture [H, W, 4] of some cloths under LIGHTS."""
    changes = {"method": "direct", "shadows": "off", "lights": LIGHTS, **changes}
    return renderer.render(cloths=cloths, camera=CAMERA, size=SIZE, env="studio", background=False, **changes).copy()


def cloth(mesh, fabric):
    return Cloth(mesh, load_fabric(fabric))


@pytest.mark.parametrize("method", ["direct", "paper", "reference"])
def test_two_cloths_are_each_as_if_alone_where_they_are_seen(renderer, meshes, method):
    """Without shadows nothing else can change: to the bit."""
    changes = {"method": method, "cube": 6, "grid": 12}
    first, second = cloth(meshes[0], LINEN), cloth(meshes[1], SATIN)
    alone = [picture(renderer, [one], **changes) for one in (first, second)]
    both = picture(renderer, [first, second], **changes)
    assert np.array_equal(both[..., 3] > 0, (alone[0][..., 3] > 0) | (alone[1][..., 3] > 0))
    from_first, from_second = (np.all(both == one, axis=-1) & (one[..., 3] > 0) for one in alone)
    assert np.all((from_first | from_second)[both[..., 3] > 0])
    # The first stands before the second.
    overlap = (alone[0][..., 3] > 0) & (alone[1][..., 3] > 0)
    assert overlap.sum() > 50 and np.all(from_first[overlap])
    assert (from_second & ~from_first).sum() > 300 and (from_first & ~from_second).sum() > 300


def test_their_order_does_not_matter_where_nothing_hides_light(renderer, meshes):
    first, second = cloth(meshes[0], LINEN), cloth(meshes[1], SATIN)
    assert np.array_equal(picture(renderer, [first, second]), picture(renderer, [second, first]))


def test_crossing_cloths_are_cut_at_each_other(renderer):
    sphere = load_mesh("sphere")
    first, second = cloth(sphere, LINEN), cloth(moved(sphere, (0.5, 0.0, 0.0)), SATIN)
    both = picture(renderer, [first, second])
    alone = [picture(renderer, [one]) for one in (first, second)]
    of_first = np.all(both == alone[0], axis=-1) & (both[..., 3] > 0)
    of_second = np.all(both == alone[1], axis=-1) & (both[..., 3] > 0)
    assert np.all((of_first | of_second)[both[..., 3] > 0]) and of_first.sum() > 300 and of_second.sum() > 300


def test_one_cloth_casts_its_shadow_on_another(renderer):
    """The sun stands to the right; a cloth there darkens the one to the left, which is seen as before."""
    sun = Lights(LIGHTS.gaussians, Suns(np.array([[0.8, 0.6, 0.0]]), np.array([[9.0, 9.0, 9.0]])))
    left = cloth(moved(load_mesh("sphere"), (-0.4, -0.2, 0.0)), LINEN)
    right = cloth(moved(load_mesh("sphere"), (0.7, 0.6, 0.0)), SATIN)
    changes = {"shadows": "full", "bounce": False, "lights": sun}
    alone, both = picture(renderer, [left], **changes), picture(renderer, [left, right], **changes)
    seen = renderer.gbuffer.covered()
    a, b = luminance(alone[..., :3])[seen], luminance(both[..., :3])[seen]
    assert seen.sum() > 500 and b.sum() < 0.8 * a.sum()
    # The side that the sun does not reach loses only light of the sky.
    away = np.argwhere(seen)[:, 1] < np.quantile(np.argwhere(seen)[:, 1], 0.15)
    assert b[away].sum() > 0.85 * a[away].sum()


def test_light_goes_from_one_cloth_to_another(renderer, meshes):
    """A red cloth beside a white one reddens it; without the bounce it does not."""
    white = load_fabric(LINEN)
    red = white.changed(yarn=tuple(yarn.changed(albedo=(0.9, 0.02, 0.02)) for yarn in white.yarn))
    near = moved(meshes[0], (0.0, 0.0, 0.0)), moved(load_mesh("sphere"), (1.6, 0.0, 0.0))

    def redness(other, bounce):
        shown = picture(renderer, [Cloth(near[0], white), Cloth(near[1], other)], shadows="full", bounce=bounce)
        mine = renderer.gbuffer.covered()
        return shown[mine][:, 0].sum() / shown[mine][:, 2].sum()

    assert redness(red, True) > 1.004 * redness(white, True)
    assert redness(red, False) == pytest.approx(redness(white, False), rel=1e-6)


def test_two_cloths_stand_on_a_ground(renderer, meshes):
    ground = Objects((), (), stand_on(meshes[0], [], None, (0.3, 0.3, 0.3)))
    cloths = [cloth(meshes[0], LINEN), cloth(meshes[1], SATIN)]
    for method in ("direct", "reference"):
        shown = picture(renderer, cloths, method=method, cube=6, shadows="full", objects=ground)
        assert np.isfinite(shown).all() and (shown[..., 3] > 0).mean() > 0.5
        assert renderer.covered_pixels() > 1000


def test_samples_and_adaptive_rate_with_two_cloths(renderer, meshes):
    cloths = [cloth(meshes[0], LINEN), cloth(meshes[1], SATIN)]
    full = picture(renderer, cloths)
    adaptive = picture(renderer, cloths, adaptive=True)
    assert np.array_equal(full[..., 3], adaptive[..., 3])
    assert (
        np.abs(luminance(adaptive[..., :3]) - luminance(full[..., :3])).mean() < 0.01 * luminance(full[..., :3]).mean()
    )
    several = picture(renderer, cloths, spp=4)
    assert several[..., 3].max() == pytest.approx(1.0, abs=1e-6)


def test_a_cloth_alone_is_the_same_to_the_bit_after_two(renderer, meshes):
    first, second = cloth(meshes[0], LINEN), cloth(meshes[1], SATIN)
    before = picture(renderer, [first], shadows="full")
    picture(renderer, [first, second], shadows="full")
    assert np.array_equal(picture(renderer, [first], shadows="full"), before)


def test_what_a_cloth_sees_is_looked_at_anew_when_another_moves(renderer):
    """The bits of a scene that began there: a copy of the first cloth has seen nothing yet."""
    left = [cloth(moved(load_mesh("sphere"), (-0.4, -0.2, 0.0)), LINEN) for _ in range(2)]
    away, near = (cloth(moved(load_mesh("sphere"), place), SATIN) for place in ((3.0, 0.6, -2.0), (0.7, 0.6, 0.0)))
    changes = {"shadows": "full", "bounce": False}
    before = picture(renderer, [left[0], away], **changes)
    after = picture(renderer, [left[0], near], **changes)
    assert np.abs(after - before).max() > 0.01
    assert np.array_equal(after, picture(renderer, [left[1], near], **changes))


def test_parts_of_one_mesh_wear_their_own_fabrics(renderer, meshes, tmp_path):
    """A picture by names is the one by cloths, to the bit; parts of one fabric are one cloth, with its time and its bits."""
    from glcloth.geometry.parts import joined

    both = joined(meshes)
    part_of = np.repeat([0, 1], [len(mesh.triangles) for mesh in meshes])
    named = replace(both, parts=(("Bodice",), ("Trim left",)), part_of=part_of)
    changes = {"lights": LIGHTS, "camera": CAMERA, "size": SIZE, "background": False, "shadows": "off"}
    by_name = renderer.render(mesh=named, fabric=LINEN, fabrics={"trim*": SATIN}, **changes).copy()
    assert renderer.facts()["fabric"].startswith(load_fabric(LINEN).name + ", ")
    assert np.array_equal(by_name, picture(renderer, [cloth(meshes[0], LINEN), cloth(meshes[1], SATIN)]))
    alike = renderer.render(mesh=named, fabric=LINEN, fabrics={"trim*": LINEN}, **changes).copy()
    assert len(renderer.stage.cloths_in_frame) == 1
    assert np.array_equal(alike, picture(renderer, [cloth(both, LINEN)]))
    # Several meshes are one cloth, too, where they share a fabric, and framed together.
    renderer.render(mesh=list(meshes), fabric=LINEN, size=(16, 12), shadows="off", lights=LIGHTS)
    assert len(renderer.stage.cloths_in_frame) == 1
    frame = renderer.prepare(mesh=list(meshes), fabrics={meshes[1].name.replace("[", "?"): SATIN}, lights=LIGHTS)
    assert len(frame.cloths) == 2 and frame.camera.target == pytest.approx(tuple(both.center))


def test_what_bounces_off_a_fabric_is_known_well(renderer):
    """Its reflectance in steps of a percent, and what a furnace of narrow lobes shows each viewer."""
    renderer.render(mesh="plane", fabric=SATIN, lights=LIGHTS, size=(16, 12), quality="draft", background=False)
    cloth = renderer.stage.cloths[0]
    furnace, fabric = cloth.visibility.furnace, load_fabric(SATIN)
    exact = furnace.albedo(cloth.scene_buffers) * cloth.visibility.limit
    np.testing.assert_allclose(cloth.reflectance, exact, rtol=0.0051)
    rows, columns = np.arange(12), np.arange(0, 24, 11)
    texels = np.frombuffer(furnace.views(cloth.scene_buffers).read(), "f2").reshape(2, 12, 24, 4)[0, :, columns, :3]
    lit = even_directions(3000)
    got, expected = [], []
    for row in rows:
        for column, texel in zip(columns, texels[:, row], strict=True):
            z, phi = (row + 0.5) / 12, 2 * np.pi * (column + 0.5) / 24
            view = np.array([np.sqrt(1 - z * z) * np.cos(phi), np.sqrt(1 - z * z) * np.sin(phi), z])
            expected.append(luminance(2 * np.pi * f_cloth(lit, view, *fabric.arrays()).mean(0)))
            got.append(luminance(texel.astype(float)))
    error = np.abs(np.array(got) - expected)
    assert error.mean() < 0.03 * np.mean(expected)
    # By the cosines of light and view: the mean cosine of the light is 2/3 - flat_share / 3, half the slope by the view.
    u = np.random.default_rng(0).random((4, 40_000))
    z, turn = np.stack([u[0], np.sqrt(u[1])]), 2 * np.pi * u[2:]
    r = np.sqrt(1 - z * z)
    light, view = np.moveaxis(np.stack([r * np.cos(turn), r * np.sin(turn), z], -1), 0, 0)
    f = luminance(f_cloth(light, view, *fabric.arrays()))
    f /= f.mean()
    given = furnace.given(cloth.scene_buffers)
    assert given.flat_share == pytest.approx(2 - 3 * (f * z[0]).mean(), abs=0.04)
    assert given.upright == pytest.approx(9 * (f * (z[1] - 2 / 3)).mean(), abs=0.06)
    of_height = 108 * (f * (z[0] - 0.5) * (z[1] - 2 / 3)).mean()
    assert given.upright_of_height == pytest.approx(of_height, abs=0.3)
