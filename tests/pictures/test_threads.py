"""Threads near by: their mean is the far cloth, and the far cloth is what it was."""

import moderngl
import numpy as np
import pytest

from glcloth.color import luminance
from glcloth.fabric import load_fabric
from glcloth.geometry.camera import Camera
from glcloth.geometry.mesh import build_mesh
from glcloth.light.lights import Lights, SphericalGaussians, Suns
from glcloth.methods import relief, weave_maps
from glcloth.methods.relief import LEVELS, SIDE, relief_table
from glcloth.methods.weave_maps import WeaveMaps, fabric_maps, level_inputs, repeat_of
from glcloth.picture import uv_scale
from glcloth.weave.levels import levels_of, side_by_side
from glcloth.weave.maps import mip_levels

EVEN = {"shift": 0.0, "yarn": 0.0, "fibre": 0.0}


def woven(name, **changes):
    """A fabric without the hairs that stand out beyond a sheet of it."""
    fabric = load_fabric(name)
    return fabric.changed(weave=fabric.weave.changed(**{"fuzz": 0.0, **changes}))


def even(name):
    """A fabric whose yarns are all alike, so that a few repeats have the mean of all."""
    fabric = load_fabric(name)
    return woven(name, irregularity=fabric.weave.irregularity.changed(**EVEN))


def patch(fabric, side=0.02, uv_unit=1.0):
    """A sheet of whole repeats, about `side` metres wide, in the plane z = 0."""
    w, h = (repeat * max(round(side / repeat), 1) for repeat in repeat_of(fabric))
    corners = np.array([[-w, -h, 0], [w, -h, 0], [w, h, 0], [-w, h, 0]]) / 2
    return build_mesh("sheet", corners, np.array([[0, 1, 2], [0, 2, 3]]), corners[:, :2] / uv_unit, None)


def camera(theta_deg, phi_deg, side=0.02, lengths=40.0):
    theta, phi = np.radians([theta_deg, phi_deg])
    toward = np.array([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)])
    fov = np.degrees(2.0 * np.arctan(0.85 / lengths))
    return Camera(tuple(lengths * side * toward), (0.0, 0.0, 0.0), (0.0, 1.0, 0.1), float(fov))


LOOK = {"threads": True, "size": (320, 320), "shadows": "off", "background": False}


@pytest.mark.parametrize(
    ("name", "relief"),
    [
        ("linen_heavy", 0.0), ("denim_raw", 0.0), ("duchesse_satin", 0.0), ("silk_shot", 0.0), ("houndstooth", 0.0),
        ("linen_heavy", 1.0), ("denim_raw", 1.0),
    ],
)  # fmt: skip
def test_mean_of_whole_repeats_is_the_far_cloth(renderer, name, relief):
    fabric = even(name)
    fabric = fabric.changed(weave=fabric.weave.changed(relief=relief))
    side = max(0.02, 6.0 * max(repeat_of(fabric)))
    mesh = patch(fabric, side)
    for theta, phi in ((5, 20), (40, 70), (60, 200), (75, 130), (150, 40)):
        view = camera(theta, phi, side)
        near = renderer.render(fabric=fabric, mesh=mesh, camera=view, **LOOK)
        assert renderer.stage.cloths[0].threads.shown and np.isfinite(near).all()
        far = renderer.render(fabric=fabric.changed(weave=None), mesh=mesh, camera=view, **LOOK)
        assert near[..., 1].std() > 0.1 * near[..., 1].mean()
        np.testing.assert_allclose(
            near.mean((0, 1)), far.mean((0, 1)), rtol=(3e-2 if theta == 75 else 1e-2) if relief else 4e-3
        )


def test_wandering_yarns_keep_the_mean(renderer):
    fabric = woven("denim_raw")
    mesh = patch(fabric, 0.3)
    view = camera(30, 70, 0.3)
    look = {**LOOK, "size": (640, 640)}
    near, far = (
        renderer.render(fabric=f, mesh=mesh, camera=view, **look) for f in (fabric, fabric.changed(weave=None))
    )
    np.testing.assert_allclose(near.mean((0, 1)), far.mean((0, 1)), rtol=1e-2)


def test_far_cloth_is_the_same_to_the_bit(renderer):
    fabric = load_fabric("linen_heavy")
    for changes in ({}, {"adaptive": True}):
        look = {"threads": True, "size": (160, 120), "shadows": "off", "camera": Camera((0.0, 2.0, 6.0)), **changes}
        far = renderer.render(fabric=fabric.changed(weave=None), **look)
        assert np.array_equal(renderer.render(fabric=fabric, **look), far)
        assert not renderer.stage.cloths[0].threads.shown


def test_pixels_beyond_a_repeat_are_those_of_the_far_cloth(renderer):
    """On a sheet that runs to the horizon some pixels show threads and some do not."""
    fabric = load_fabric("denim_raw")
    mesh = patch(fabric, 40.0)
    look = {**LOOK, "size": (160, 160), "camera": Camera((0.0, 0.0, 0.05), (0.0, 0.1, 0.0), (0.0, 0.0, 1.0), 60.0)}
    near, far = (renderer.render(fabric=f, mesh=mesh, **look) for f in (fabric, fabric.changed(weave=None)))
    same = (near == far).all(-1) & (far[..., 3] > 0.0)
    assert 0.05 < same.sum() / (far[..., 3] > 0.0).sum() < 0.95


def test_reference_judges(renderer):
    fabric = even("denim_raw")
    mesh, view = patch(fabric, 0.004), camera(35, 70, 0.004)
    look = {**LOOK, "size": (40, 40), "mesh": mesh, "camera": view, "fabric": fabric, "lobes": 4}
    judge, direct = (renderer.render(method=method, **look)[..., :3] for method in ("reference", "direct"))
    assert np.abs(direct - judge).mean() < 0.02 * judge.mean()


def corner(side=0.04, cells=6):
    """A floor z = 0 and a wall at its end x = side / 2, one cloth, in cells."""
    q = np.linspace(-0.5, 0.5, cells + 1)
    u, v = (a.ravel() for a in np.meshgrid(q, q, indexing="ij"))
    floor, wall = np.stack([u, v, 0 * u], -1), np.stack([0.5 + 0 * u, v, u + 0.5], -1)
    k = (np.arange(cells)[:, None] * (cells + 1) + np.arange(cells)).ravel()
    faces = np.concatenate(
        [np.stack(f, -1) for f in ((k, k + cells + 1, k + 1), (k + 1, k + cells + 1, k + cells + 2))]
    )
    uv = side * np.concatenate([np.stack([u, v], -1), np.stack([1.0 + u, v], -1)])
    triangles = np.concatenate([faces, faces + len(u)])
    return build_mesh("corner", side * np.concatenate([floor, wall]), triangles, uv, None)


def test_light_that_cloth_sends_to_cloth_shows_threads(renderer):
    """A floor in no light but what a wall throws back: threads as `reference` finds them direction by direction."""
    fabric = even("houndstooth")
    fabric = fabric.changed(weave=fabric.weave.changed(ends_per_cm=24, picks_per_cm=22))  # checks of 3 mm
    sun = Suns(np.array([[-1.0, 0.0, 0.0]]), np.array([[9.0, 9.0, 9.0]]), 0.01)
    lights = Lights(SphericalGaussians(np.zeros((0, 3)), np.zeros(0), np.zeros((0, 3))), sun)
    look = {**LOOK, "size": (24, 20), "mesh": corner(), "lights": lights, "shadows": "full", "cube": 12}
    plain = fabric.changed(weave=None)

    def seen(fabric, method, fov):
        view = Camera((-0.04, 0.0, 0.06), (0.003, 0.0, 0.0), (0.0, 0.0, 1.0), fov)
        return renderer.render(fabric=fabric, method=method, **look, camera=view)[..., 1]

    np.testing.assert_allclose(seen(fabric, "direct", 14.0).mean(), seen(plain, "direct", 14.0).mean(), rtol=0.02)
    # So near that a pixel shows warp or weft, and the tangents of one alone.
    near, judge, far = seen(fabric, "direct", 5.0), seen(fabric, "reference", 5.0), seen(plain, "direct", 5.0)
    threads, right = near / far, judge / judge.mean()
    assert threads.std() > 0.2
    assert np.corrcoef(threads.ravel(), right.ravel())[0, 1] > 0.9
    assert 0.8 < threads.std() / right.std() < 1.2
    look["size"] = (96, 80)
    whole = seen(fabric, "direct", 14.0)
    look["adaptive"] = True
    assert np.abs(seen(fabric, "direct", 14.0) - whole).mean() < 0.01 * whole.mean()


def test_parts_are_the_whole(renderer):
    fabric = load_fabric("houndstooth")
    frame = renderer.prepare(fabric=fabric, mesh=patch(fabric, 0.05), camera=camera(30, 20, 0.05), **LOOK)
    whole = renderer.render_frame(frame)
    for _ in renderer.steps(frame, rows=lambda: 37):
        pass
    assert np.array_equal(renderer.target.read(), whole)


@pytest.mark.parametrize("name", ["denim_raw", "houndstooth", "charmeuse"])
def test_adaptive_rate_shows_the_same_threads(renderer, name):
    """Of yarns of one colour and of several, and of lobes with nodes of their own."""
    look = {**LOOK, "fabric": load_fabric(name), "mesh": patch(load_fabric(name), 0.1), "size": (160, 120)}
    look["camera"] = camera(35, 60, 0.006)
    whole, fast = (renderer.render(adaptive=adaptive, **look)[..., :3] for adaptive in (False, True))
    rate = renderer.stage.cloths[0].adaptive_rate
    assert rate.shaded() < 0.05 * 160 * 120 and rate.smooth() > 0.8
    assert whole[..., 1].std() > 0.1 * whole[..., 1].mean()
    np.testing.assert_allclose(fast.mean((0, 1)), whole.mean((0, 1)), rtol=1e-3)
    assert np.abs(luminance(fast - whole)).mean() < 3e-3 * luminance(whole).mean()
    # The lamp is warm, the sky is blue, and tangents turn to one of them.
    assert (np.abs(fast - whole).mean((0, 1)) < 8e-3 * whole.mean((0, 1))).all()


def test_adaptive_rate_finds_terms_more_often_in_folds(renderer):
    """Blocks are smooth only where light is, and no seam shows between those that are and those that are not."""
    mesh = build_wave()
    look = {**LOOK, "fabric": load_fabric("linen_heavy"), "mesh": mesh, "size": (120, 88)}
    look["camera"] = Camera((0.0, -0.05, 0.3), (0.0, 0.0, 0.0), (0.0, 1.0, 0.0), 5.0)
    whole, fast = (renderer.render(adaptive=adaptive, **look)[..., :3] for adaptive in (False, True))
    assert 0.1 < renderer.stage.cloths[0].adaptive_rate.smooth() < 0.9
    error = np.abs(luminance(fast - whole))
    assert error.mean() < 5e-3 * luminance(whole).mean()
    assert np.percentile(error, 99.5) < 0.15 * luminance(whole).mean()


def build_wave():
    """A sheet of 6 cm whose middle has folds a few millimetres wide."""
    x, y = np.meshgrid(np.linspace(-0.03, 0.03, 121), [-0.03, 0.03])
    z = np.where(np.abs(x) < 0.008, 4e-4 * (1.0 - np.cos(x * (2.0 * np.pi / 0.004))), 0.0)
    i = np.arange(120)
    faces = np.concatenate([np.stack([i, i + 1, i + 122], 1), np.stack([i, i + 122, i + 121], 1)])
    return build_mesh("wave", np.stack([x, y, z], -1).reshape(-1, 3), faces, np.stack([x, y], -1).reshape(-1, 2), None)


def test_adaptive_rate_knows_how_light_leans_on_pooled_lobes(renderer):
    """Light from one side, so broad that narrow lobes have nodes of their own, and so narrow that no table has it."""
    fabric = woven("duchesse_satin", irregularity=even("duchesse_satin").weave.irregularity, relief=0.0)
    axis, none = np.array([[0.0, 0.8, 0.6]]), np.zeros((0, 3))
    lights = Lights(SphericalGaussians(axis, np.array([15.0]), np.ones((1, 3))), Suns(none, none))
    look = {**LOOK, "fabric": fabric, "mesh": patch(fabric, 0.1), "size": (64, 48), "lights": lights}
    look["camera"] = camera(10, 60, 0.001)
    whole, fast = (luminance(renderer.render(adaptive=adaptive, **look)[..., :3]) for adaptive in (False, True))
    assert np.abs(fast - whole).mean() < 2e-3 * whole.mean()


def test_adaptive_rate_knows_light_of_any_unit(renderer):
    """A sun in physical units is as good as one of 1: its terms fit where they are kept."""
    fabric = woven("linen_heavy")
    look = {
        **LOOK,
        "fabric": fabric,
        "mesh": patch(fabric),
        "camera": camera(30, 50),
        "size": (64, 48),
        "adaptive": True,
    }
    pictures = []
    for unit in (1.0, 1e7):
        suns = Suns([[0.3, 0.4, 0.866]], [[2.0 * unit, 1.8 * unit, 1.5 * unit]])
        lights = Lights(SphericalGaussians([[0.0, 0.0, 1.0]], [3.0], [[unit, unit, unit]]), suns)
        pictures.append(renderer.render(lights=lights, **look)[..., :3] / unit)
    np.testing.assert_allclose(pictures[1], pictures[0], rtol=1e-3, atol=1e-5)


def test_adaptive_rate_where_only_some_pixels_show_threads(renderer):
    fabric = load_fabric("denim_raw")
    look = {**LOOK, "fabric": fabric, "mesh": patch(fabric, 40.0), "size": (160, 160)}
    look["camera"] = Camera((0.0, 0.0, 0.02), (0.0, 0.06, 0.0), (0.0, 0.0, 1.0), 60.0)
    whole, fast = (renderer.render(adaptive=adaptive, **look) for adaptive in (False, True))
    assert np.abs(luminance((fast - whole)[..., :3])).mean() < 5e-3 * luminance(whole[..., :3]).mean()
    without = renderer.render(adaptive=True, **{**look, "threads": False})
    assert np.array_equal(fast[..., 3], without[..., 3])


def test_holes_show_what_is_behind(renderer):
    """What is left of the light from behind is 1 - alpha: all of it in holes, and in the mean that of the far cloth."""
    fabric = even("lace")
    look = {**LOOK, "mesh": patch(fabric, 0.05), "camera": camera(10, 60, 0.05), "size": (240, 240)}
    near, far = (renderer.render(fabric=f, **look) for f in (fabric, fabric.changed(weave=None)))
    np.testing.assert_allclose(near.mean((0, 1)), far.mean((0, 1)), rtol=5e-3)
    near, far = (picture[90:150, 90:150, 3] for picture in (near, far))
    assert 0.1 < (near < 0.05).mean() < 0.5 and far.min() > 0.2


def test_paper_shows_the_same_threads(renderer):
    fabric = even("silk_shot")
    look = {**LOOK, "mesh": patch(fabric, 0.01), "camera": camera(30, 20, 0.01), "size": (100, 100), "lobes": 3}
    near, far = (
        renderer.render(fabric=f, method="paper", grid=12, **look) for f in (fabric, fabric.changed(weave=None))
    )
    np.testing.assert_allclose(near.mean((0, 1)), far.mean((0, 1)), rtol=4e-3)
    direct = renderer.render(fabric=fabric, **look)
    assert near[..., 1].std() > 0.2 * near[..., 1].mean()
    assert np.corrcoef(near[..., 1].ravel(), direct[..., 1].ravel())[0, 1] > 0.99


def test_uvs_that_are_no_metres(renderer, monkeypatch):
    said = []
    monkeypatch.setattr(uv_scale, "warn", said.append)
    fabric = even("linen_heavy")
    look = {**LOOK, "fabric": fabric, "camera": camera(30, 20), "size": (64, 64)}
    metres = renderer.render(mesh=patch(fabric), **look)
    assert not said
    given = renderer.render(mesh=patch(fabric, uv_unit=0.5), uv_scale=0.5, **look)
    assert not said
    guessed = renderer.render(mesh=patch(fabric, uv_unit=0.5), **look)
    assert len(said) == 1 and "0.5 m" in said[0]
    for other in (given, guessed):
        np.testing.assert_allclose(other, metres, atol=2e-3 * metres.max())


@pytest.mark.parametrize("name", ["linen_heavy", "duchesse_satin", "silk_crepe_de_chine"])
def test_every_level_of_the_maps_has_the_mean_1(name):
    for level in mip_levels(fabric_maps(load_fabric(name)).rel.astype(float)):
        np.testing.assert_allclose(level.mean((1, 2)), 1.0, rtol=1e-6)


@pytest.mark.parametrize(("axis", "light"), [(0, (0.0, 0.8, 0.6)), (1, (0.8, 0.0, 0.6))])
def test_the_side_that_turns_to_the_light_is_brighter(renderer, axis, light):
    """A picture from above under a low sun has the slopes of the height map: bright where it rises away from the sun."""
    fabric = even("linen_heavy")
    maps = fabric_maps(fabric)
    sides = []
    for sign in (1.0, -1.0):
        omega = np.array([[sign * light[0], sign * light[1], light[2]]])
        lights = Lights(
            SphericalGaussians(np.zeros((0, 3)), np.zeros(0), np.zeros((0, 3))), Suns(omega, np.ones((1, 3)))
        )
        w, h = repeat_of(fabric)
        corners = np.array([[0, 0, 0], [w, 0, 0], [w, h, 0], [0, h, 0]])
        mesh = build_mesh("repeat", corners, np.array([[0, 1, 2], [0, 2, 3]]), corners[:, :2], None)
        middle = np.array([w / 2, h / 2, 0.0])
        fov = float(np.degrees(2.0 * np.arctan(h / 2 / (20.0 * w))))
        above = Camera((w / 2, h / 2, 20.0 * w), tuple(middle), (0.0, 1.0, 0.0), fov)
        look = {**LOOK, "size": (round(128 * w / h), 128), "camera": above, "lights": lights}
        sides.append(renderer.render(fabric=fabric, mesh=mesh, **look)[::-1, :, 1])  # row 0: v = 0
    rows, columns = ((np.arange(n) * m) // n for n, m in zip(sides[0].shape, maps.height.shape, strict=True))
    slope = np.gradient(maps.height, axis=axis)[np.ix_(rows, columns)]
    inside = maps.hole[np.ix_(rows, columns)] == 0.0
    # Along this light the warp (or the weft) does not tilt: there the roll across the yarn alone tells the sides apart.
    rolls = inside & (maps.share[axis][np.ix_(rows, columns)] > 0.0)
    for where in (inside, rolls):
        difference = (sides[0] - sides[1])[where]
        assert np.corrcoef(difference, -slope[where].clip(*np.quantile(slope, (0.1, 0.9))))[0, 1] > 0.3


@pytest.mark.parametrize("axis", [0, 1])
def test_from_the_side_the_slope_that_faces_the_viewer_is_seen(ctx, monkeypatch, axis):
    """A ridge as high as a quarter of the repeat: its one slope has rel 1, the other 0, and each is seen from its own side."""
    monkeypatch.setattr(relief, "SAMPLES", 512)
    size, height = 128, 0.25
    place = (np.arange(size) + 0.5) / size
    ramp = np.maximum(1.0 - np.abs(place - 0.5) / 0.25, 0.0)
    rises_away = ((place < 0.5) & (ramp > 0.0)).astype(float)  # the slope toward smaller u or v
    layers = np.zeros((3, size, size, 4), "f4")
    layers[0, :, :, 0], layers[2, :, :, 1] = rises_away, ramp
    read = level_inputs(ctx, "weave", np.moveaxis(layers if axis == 0 else layers.swapaxes(1, 2), -1, 1), 3)
    heights = np.broadcast_to(ramp if axis == 0 else ramp[:, None], (size, size)).astype("f4")
    beside = side_by_side(heights, levels_of(size, size, 3))
    ridge = ctx.texture(beside.shape[::-1], 1, beside, dtype="f4")
    ridge.filter = moderngl.LINEAR, moderngl.LINEAR
    inputs = {
        **read, "height_levels": ridge, "weave_repeats": (1.0, 1.0), "relief_end": 99.0,
        "relief_heights": np.array([height, 1.0, 0.0], "f4"),
    }  # fmt: skip
    table = relief_table(ctx, inputs, (layers, heights), 1, 0, 0.0)
    means = np.frombuffer(table.read(), "f4").reshape(3, LEVELS, SIDE, SIDE, 4)[0, 0, ..., 0]
    row = means[SIDE // 2] if axis == 0 else means[:, SIDE // 2]
    table.release(), read["weave_levels"].release(), ridge.release()
    # Half way to the horizon's circle the tangent is 4/3: the ridge hides its far slope, and is seen 4/3 of its height behind.
    middle = SIDE // 2
    assert row[middle] == pytest.approx(0.25, abs=0.02)
    assert row[middle // 2] == pytest.approx(0.25 + 4.0 / 3.0 * height, abs=0.03), "the slope that faces the viewer"
    assert row[middle + middle // 2] < 0.02, "its back"


def test_the_table_is_kept_on_disk_as_it_was_made(ctx, monkeypatch, tmp_path):
    monkeypatch.setenv("GLCLOTH_CACHE", str(tmp_path))
    monkeypatch.setattr(relief, "SAMPLES", 64)
    fabric = load_fabric("denim_raw")

    def table():
        maps = WeaveMaps(ctx)
        return maps.inputs(fabric, -(-len(fabric.tangents) // 4), 4)["relief_table"].read()

    first = table()
    (file,) = (tmp_path / "relief").iterdir()
    with monkeypatch.context() as patch:
        patch.setattr(relief, "programs", None)  # it is not made anew
        assert table() == first
    file.write_bytes(file.read_bytes()[:-9])
    assert table() == first
    monkeypatch.setattr(relief, "SAMPLES", 65)
    assert table() != first and len(list((tmp_path / "relief").iterdir())) == 2
    # Other heights make another table, even where all else is the same.
    calls = []
    monkeypatch.setattr(weave_maps, "relief_table", lambda *all: calls.append(all) or relief_table(*all))
    table()
    ctx_, read, (layers, height), *rest = calls[0]
    relief_table(ctx_, read, (layers, height + 0.01), *rest).release()
    assert len(list((tmp_path / "relief").iterdir())) == 3


def test_threads_are_shown_unless_they_are_not_wanted(renderer):
    fabric = even("denim_raw")
    look = {**LOOK, "mesh": patch(fabric), "camera": camera(30, 20, 0.008), "size": (64, 64)}
    del look["threads"]
    far, near = renderer.render(fabric=fabric, threads=False, **look), renderer.render(fabric=fabric, **look)
    assert np.array_equal(far, renderer.render(fabric=fabric.changed(weave=None), **look))
    assert np.abs(near - far).mean() > 0.05 * far.mean()
