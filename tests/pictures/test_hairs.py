"""Hairs stand out beyond the outline of spun cloth, and nowhere else."""

import numpy as np
import pytest
from PIL import Image

from glcloth.color import luminance
from glcloth.fabric import load_fabric
from glcloth.geometry import hairs
from glcloth.geometry.camera import Camera
from glcloth.geometry.hairs import hairs_in_view, rim_edges, shown_width
from glcloth.geometry.mesh import build_mesh
from glcloth.light.lights import Lights, SphericalGaussians, Suns
from glcloth.picture.frame import Cloth
from glcloth.picture.fuzz import DIAMETER
from glcloth.twins.hair import hair_cover, hair_place

END = np.array([0.1, 0.0, 0.0])
EVEN = Lights(SphericalGaussians(np.array([[0.0, 0.0, 1.0]]), np.array([0.0]), np.ones((1, 3))))


def sheet():
    """Its upper rim goes through the origin."""
    corners = np.array([[-0.1, -0.1, 0], [0.1, -0.1, 0], [0.1, 0, 0], [-0.1, 0, 0]])
    return build_mesh("sheet", corners, np.array([[0, 1, 2], [0, 2, 3]]), corners[:, :2], None)


def half_cylinder(radius=0.02, count=120):
    turn = np.pi * (np.arange(count) / (count - 1) - 0.5)
    ring = radius * np.stack([np.zeros(count), np.cos(turn), np.sin(turn)], 1)
    positions = np.concatenate([ring - END, ring + END])
    i, j = np.arange(count - 1), np.arange(1, count)
    triangles = np.concatenate([np.stack([i, j, i + count], 1), np.stack([j, j + count, i + count], 1)])
    uv = np.concatenate([np.stack([np.full(count, x), radius * turn], 1) for x in (0.0, 0.2)])
    return build_mesh("half a cylinder", positions, triangles, uv, None)


def camera(width, aspect=4 / 3, target=(0.0, 0.0, 0.0)):
    return Camera(
        (target[0], target[1], 0.4), target, (0.0, 1.0, 0.0), float(2 * np.degrees(np.arctan(width / aspect / 0.8)))
    )


LOOK = {"lights": EVEN, "size": (200, 150), "shadows": "off", "background": False}


def fuzzy(fuzz, name="flannel"):
    fabric = load_fabric(name)
    return fabric.changed(weave=fabric.weave.changed(fuzz=fuzz, relief=0.0))


@pytest.mark.parametrize("width", [0.3, 2.0, 9.0])
def test_a_hair_covers_what_it_is_wide(width):
    x = np.linspace(-9, 9, 20_001)
    assert np.isclose(hair_cover(x, width).sum() * (x[1] - x[0]), width, rtol=1e-3)
    number = np.random.default_rng(1).random(200_000)
    for pixel in (1e-5, 6e-5, 4e-4):
        drawn = shown_width(np.full(len(number), pixel), 2e-5, number)
        assert np.isclose(drawn.mean(), 1.0, atol=0.02)


def test_hairs_stay_where_they_are():
    mesh = half_cylinder()
    rim = rim_edges(mesh)
    assert len(rim) == 2 * 119 + 2

    def found(eye):
        hairs = hairs_in_view(
            mesh, mesh.positions[rim], 1.0, Camera(eye, (0, 0.02, 0), (0, 1, 0), 4.0), (200, 150), 9e6, 1e-3, 2e-5, 1e-3
        )
        rows = np.column_stack([hairs.triangle, hairs.weights, hairs.random[:, :6]])
        return {tuple(row) for row in np.round(rows, 9)}, hairs

    (here, hairs), (there, _) = found((0.0, 0.02, 0.3)), found((0.0, 0.024, 0.3))
    assert len(here & there) > 0.7 * len(here) > 300
    assert (hairs.side == 0).all()  # the inside is not seen


def test_hairs_stand_out_and_the_cloth_stays(renderer):
    with_hairs, without = (
        renderer.render(mesh=sheet(), fabric=fuzzy(fuzz), camera=camera(0.03), **LOOK) for fuzz in (12.0, 0.0)
    )
    beyond, rim, within = slice(0, 74), slice(76, 110), slice(110, 150)
    assert without[beyond, :, 3].max() == 0.0 and 0.002 < with_hairs[50:74, :, 3].mean() < 0.2
    assert with_hairs[beyond, :, 3].max() <= 1.0 and np.allclose(with_hairs[76:, :, 3], 1.0, atol=1e-5)
    assert np.array_equal(with_hairs[within], without[within])
    assert not np.array_equal(with_hairs[rim], without[rim])
    assert np.isclose(with_hairs[rim].mean(), without[rim].mean(), rtol=0.01)
    # Before the cloth hairs make it lighter or darker, and mix no colour of theirs into it.
    lighter = with_hairs[rim, :, :3].astype(float) / without[rim, :, :3]
    assert np.ptp(lighter, axis=-1).max() < 1e-4
    hair = with_hairs[beyond, :, :3].sum((0, 1)) / with_hairs[beyond, :, 3].sum()
    assert 0.6 < luminance(hair) / luminance(without[within, :, :3].mean((0, 1))) < 1.4


def test_no_hairs_from_afar_nor_before_objects_that_hide_them(renderer):
    far = [renderer.render(mesh=sheet(), fabric=fuzzy(fuzz), camera=camera(0.6), **LOOK) for fuzz in (12.0, 0.0)]
    assert np.array_equal(*far)
    # Threads of a wide pattern are seen from farther: in pixels of 2 mm a hair of 1.8 mm would be a dot.
    wide = [renderer.render(mesh=sheet(), fabric=fuzzy(n, "tartan"), camera=camera(0.4), **LOOK) for n in (12.0, 0.0)]
    assert renderer.stage.cloths[0].threads.shown and np.array_equal(*wide)
    # A cloth in front of the rim hides its hairs.
    front = build_mesh(
        "front", np.array([[-0.1, -0.1, 0.02], [0.1, -0.1, 0.02], [0.1, 0.1, 0.02], [-0.1, 0.1, 0.02]]),
        np.array([[0, 1, 2], [0, 2, 3]]), np.array([[0.0, 0], [0.2, 0], [0.2, 0.2], [0, 0.2]]), None,
    )  # fmt: skip
    hidden = [
        renderer.render(
            cloths=[Cloth(sheet(), fuzzy(fuzz)), Cloth(front, load_fabric("velvet"))], camera=camera(0.012), **LOOK
        )
        for fuzz in (12.0, 0.0)
    ]
    assert np.array_equal(*hidden)


def test_hairs_leave_the_cover_of_a_pixel_alone(renderer):
    """Where cloth covers a part of a pixel, they once took alpha from it, and made its colour too bright."""
    look = {**LOOK, "mesh": sheet(), "camera": camera(0.03, target=(0.0, 12e-5, 0.0)), "spp": 16}
    with_hairs, without = (renderer.render(fabric=fuzzy(fuzz), **look) for fuzz in (60.0, 0.0))
    edge = (without[..., 3] > 0.0) & (without[..., 3] < 1.0)
    assert edge.any() and (with_hairs[..., 3] >= without[..., 3] - 1e-6).all()
    colors = [picture[edge, :3] / picture[edge, 3:] for picture in (with_hairs, without)]
    assert colors[0].max() < 1.35 * colors[1].max()


def test_no_hairs_where_cloth_is_cut_out_or_of_another_fabric(renderer, tmp_path):
    """The mask's border is across the picture; above it cloth is cut out, and its rim is there."""
    file = str(tmp_path / "half.png")
    codes = np.zeros((2, 1, 3), np.uint8)
    codes[0] = 255
    Image.fromarray(codes).save(file)
    x, y = np.meshgrid(np.linspace(-0.1, 0.1, 41), np.linspace(-0.1, 0.0, 21))
    at = np.arange(x.size).reshape(x.shape)[:-1, :-1].ravel()
    triangles = np.concatenate([at[:, None] + [0, 1, 42], at[:, None] + [0, 42, 41]])
    mesh = build_mesh("grid", np.stack([x, y, 0 * x], -1).reshape(-1, 3), triangles,
                      np.stack([10 * x + 1, 10 * y + 1], -1).reshape(-1, 2), None)  # fmt: skip
    look = {**LOOK, "mesh": mesh, "uv_scale": 0.1, "camera": camera(0.03, target=(0.0, -0.05, 0.0))}
    masked = {"fabric": "velvet", "fabric_mask": file}
    both = [renderer.render(**masked, fabrics={"#000000": fuzzy(fuzz)}, **look) for fuzz in (12.0, 0.0)]
    assert np.array_equal(*both)
    look["camera"] = camera(0.03)
    codes = 255 - codes
    Image.fromarray(codes).save(file)
    cut = [renderer.render(fabric=fuzzy(fuzz), opacity=file, **look) for fuzz in (12.0, 0.0)]
    assert np.array_equal(*cut)


@pytest.mark.parametrize("ortho", [None, 0.03])
def test_uvs_that_are_far_too_large_take_no_more_memory(monkeypatch, ortho):
    cells = []
    monkeypatch.setattr(hairs, "MOST_CELLS", 1 << 17)
    monkeypatch.setattr(hairs, "_bits", lambda cell, own=hairs._bits: cells.append(len(cell)) or own(cell))
    mesh = half_cylinder()
    view = Camera((0, 0.02, 0.3), (0, 0.02, 0), (0, 1, 0), 4.0, ortho=ortho)
    for metres in (1.0, 30.0, 1e30):
        cells.clear()
        hairs_in_view(mesh, mesh.positions[rim_edges(mesh)], metres, view, (200, 150), 9e6, 1e-3, 2e-5, 1e-3)
        assert sum(cells) < 1 << 19


def test_hairs_without_any_light_are_black(renderer):
    none = np.zeros((0, 3))
    dark = Lights(SphericalGaussians(none, np.zeros(0), none), Suns(none, none))
    look = {**LOOK, "lights": dark, "size": (80, 60)}
    bare, picture = (renderer.render(mesh=sheet(), fabric=fuzzy(n), camera=camera(0.012), **look) for n in (0.0, 20.0))
    assert not picture[..., :3].any() and picture[..., 3].sum() > bare[..., 3].sum()
    assert renderer.stage.cloths[0].fuzz._lights.value["light_count"] == 1


def test_hairs_cover_as_much_as_they_are_long_and_wide(renderer):
    """Few of them, so that hardly any lie over each other: alpha beyond the rim adds up to lengths times widths."""
    fabric, view, (width, height) = fuzzy(2.0), camera(0.012), LOOK["size"]
    got = float(renderer.render(mesh=sheet(), fabric=fabric, camera=view, **LOOK)[:75, :, 3].sum())
    found = renderer.stage.cloths[0].fuzz.last
    corners = sheet().positions[sheet().triangles[found.triangle]]
    weights = np.column_stack([1.0 - found.weights.sum(1), found.weights])
    s = np.linspace(0.0, 1.0, 201)
    front = (found.side == 0)[:, None]
    one, other = found.random[:, :4], found.random[:, 4:8]
    way, bend = np.where(front, one, other)[:, None], np.where(front, other, one)[:, None]
    length = 1e-3 * fabric.weave.fuzz_length * found.length[:, None, None]
    out = hair_place(way, bend, s[None]) * np.where(front[..., None], 1.0, [1.0, 1.0, -1.0])
    place = (weights[:, :, None] * corners).sum(1)[:, None] + length * out
    pixel = 2.0 * np.tan(np.radians(view.fov_deg) / 2) / height * (0.4 - place[..., 2])
    at = place[..., :2] / pixel[..., None]
    middle = 0.5 * (at[:, 1:] + at[:, :-1])
    shown = (middle[..., 1] > 0.0) & (middle[..., 1] < height / 2) & (np.abs(middle[..., 0]) < width / 2)
    taper = 1.0 - 0.6 * (0.5 * (s[1:] + s[:-1])) ** 2
    wide = found.width[:, None] * DIAMETER / pixel[:, 1:] * taper
    expected = float((np.linalg.norm(np.diff(at, axis=1), axis=-1) * wide * shown).sum())
    assert expected > 15.0 and got == pytest.approx(expected, rel=0.12)


def test_hairs_in_the_shade_are_dark(renderer):
    """A cloth out of sight stands between them and the light."""
    lamp = Lights(SphericalGaussians(np.array([[0.0, 0.7071, 0.7071]]), np.array([200.0]), np.full((1, 3), 500.0)))
    x, y = np.array([1.0, 0, 0]), np.array([0.0, 0.7071, -0.7071])
    corners = np.array([0.0, 0.3, 0.3]) + np.array(
        [-0.5 * x - 0.2 * y, 0.5 * x - 0.2 * y, 0.5 * x + 0.2 * y, 0.2 * y - 0.5 * x]
    )
    roof = build_mesh("roof", corners, np.array([[0, 1, 2], [0, 2, 3]]), np.eye(4)[:, :2], None)
    look = {**LOOK, "lights": lamp, "shadows": "full", "size": (100, 75), "camera": camera(0.012)}
    of_hairs = []
    for others in ([], [Cloth(roof, load_fabric("velvet"))]):
        picture = renderer.render(cloths=[Cloth(sheet(), fuzzy(12.0)), *others], bounce=False, **look)[:36]
        of_hairs.append(float(picture[..., :3].sum() / picture[..., 3].sum()))
    assert of_hairs[0] > 0.05 and of_hairs[1] < 0.2 * of_hairs[0]
