"""The tracer with several fabrics, and with a sun: each layer by itself, one fabric twice, the curtains that have them, discs."""

import dataclasses

import numpy as np
import pytest
from test_tracer import DARK, ROOM_CAMERA, ROOM_LIGHT, VOILE, WHITE, folded_scene, pixel_directions, rectangle, through

from glcloth.color import luminance
from glcloth.curtain.show import CurtainShow
from glcloth.errors import InputError
from glcloth.fabric import load_fabric
from glcloth.geometry.camera import Camera
from glcloth.light.environment import Environment
from glcloth.light.suns import split_suns
from glcloth.scene import Scene
from glcloth.tracing.lamp import Lamp, Lighting
from glcloth.tracing.shot import Shot, TraceSettings
from glcloth.tracing.tracer import Tracer

LINEN = load_fabric("linen_curtain")
# Hardly a mirror.
DULL = [f.changed(transmission=f.transmission.changed(eta_1=1.0, eta_2=1.02)) for f in (VOILE, LINEN)]
# A warp that lies flat: as many tangents of one yarn as of the other would hide whose they are.
PLAIN = {"curve_angles_deg": None, "curve_lengths": None, "samples": None, "shares": None}
DULL[1] = DULL[1].changed(weave=None, yarn=(LINEN.yarn[0].changed(**PLAIN, tangents_deg=(0.0,)), LINEN.yarn[1]))


@pytest.fixture
def tracer(ctx):
    tracer = Tracer(ctx)
    yield tracer
    tracer.release()


def test_each_layer_is_of_its_fabric(tracer):
    """A floor behind two sheets in the lamp's light, which passes both, seen through both: two products."""
    lamp = np.array([0.3, 0.4, 9.0])
    wall, sheets = rectangle(-2.0), [rectangle(0.0), rectangle(-1.0)]
    positions = np.concatenate([wall, *sheets])
    shot = Shot(
        Camera((0, 0, 4), (0, 0, 0), fov_deg=60), (16, 8), DULL[0], Lighting(Lamp(tuple(lamp), WHITE), DARK, DARK),
        others=((4, DULL[1]),),
    )  # fmt: skip
    tangents = np.broadcast_to([1.0, 0.0, 0.0], positions.shape)
    got = tracer.render(positions, np.repeat([1, 0, 0], 2), np.full((2, 3), 0.5), shot, tangents=tangents)
    voile, linen = (
        tracer.render(
            sheet, np.zeros(2, int), np.full((2, 3), 0.5), dataclasses.replace(shot, fabric=fabric, others=()),
            tangents=tangents[:2],
        )
        for fabric, sheet in zip(DULL, sheets, strict=True)
    )  # fmt: skip
    d = -pixel_directions(shot.camera, (16, 8))
    p = np.array(shot.camera.eye) + d * (-6.0 / d[..., 2:])
    toward = lamp - p
    r = np.linalg.norm(toward, axis=-1, keepdims=True)
    toward /= r
    on_wall = 0.5 / np.pi * toward[..., 2:] / r**2
    for fabric in DULL:
        on_wall = on_wall * through(toward, fabric, half=True) * through(d, fabric)
    # What the linen reflects passes the voile twice.
    q = np.array(shot.camera.eye) + d * (-5.0 / d[..., 2:])
    toward = (lamp - q) / np.linalg.norm(lamp - q, axis=-1, keepdims=True)
    expected = on_wall + voile + linen * through(toward, DULL[0], half=True) * through(d, DULL[0])
    np.testing.assert_allclose(got, expected, rtol=2e-3)


def test_one_fabric_twice_is_one(tracer):
    scene = folded_scene(17, 9)
    settings = TraceSettings(depth=3)
    shot = Shot(ROOM_CAMERA, (24, 24), VOILE, ROOM_LIGHT, settings=settings)
    one = tracer.render(**scene, shot=shot)
    middle = len(scene["positions"]) - 100
    two = tracer.render(**scene, shot=dataclasses.replace(shot, others=((middle, VOILE),)))
    np.testing.assert_allclose(two, one, rtol=1e-5, atol=1e-6)
    other = tracer.render(**scene, shot=dataclasses.replace(shot, others=((middle, LINEN),)))
    assert np.abs(other - one).max() > 0.01


def test_wrong_input():
    shot = Shot(ROOM_CAMERA, (8, 8), VOILE)
    with pytest.raises(InputError, match="Linen plain: has no \\[transmission\\]"):
        dataclasses.replace(shot, others=((3, load_fabric("linen")),))
    with pytest.raises(InputError, match="5 fabrics in one picture"):
        dataclasses.replace(shot, others=tuple((k, VOILE) for k in range(4)))


# A box of 2 m that is open where its window is, seen from its back wall.
BOX = """v -1 0 0\nv 1 0 0\nv 1 2 0\nv -1 2 0\nv -1 0 2\nv 1 0 2\nv 1 2 2\nv -1 2 2
f 1 5 6\nf 1 6 2\nf 4 3 7\nf 4 7 8\nf 1 4 8\nf 1 8 5\nf 2 6 7\nf 2 7 3\nf 5 8 7\nf 5 7 6
"""


def test_a_second_curtain_by_every_way_that_light_takes(renderer, tmp_path):
    (tmp_path / "box.obj").write_text(BOX)
    small = {"quads": (48, 12), "pleats": 4, "settle": 0.05, "behind": "linen_curtain"}
    small |= {"width": 1.9, "top": 1.9, "drop": 1.8}
    scene = Scene(
        gi="off", curtain=small, size=(20, 20), frame=0, fabric="sheer_voile", photons=20_000, photon_neighbours=100,
        room=str(tmp_path / "box.obj"), camera={"eye": (0.3, 1.0, 1.9), "target": (0.0, 1.0, 0.0), "fov_deg": 80.0},
    )  # fmt: skip
    by_photons = luminance(np.asarray(renderer.render(scene.changed(gi="photons")), float))
    renderer.render(scene.changed(method="path", spp=20))
    sums = renderer.path_sums()
    by_paths, noise = luminance(sums.picture[..., :3].astype(float)), np.sqrt((sums.standard_error**2).mean()) / 20
    assert abs(by_photons.mean() / by_paths.mean() - 1) < 0.04 + 4 * noise / by_paths.mean()
    # Which one is before: through the sheer one the red one behind is seen, through blackout nothing.
    middle = slice(7, 13), slice(7, 13)
    red = scene.changed(curtain=small | {"behind_color": "red"})
    seen, hidden = (
        np.asarray(renderer.render(s), float)[middle].mean((0, 1)) for s in (red, red.changed(fabric="blackout"))
    )
    assert seen[0] > 1.5 * seen[1] and hidden[0] < 1.2 * hidden[1]
    # Radiosity knows what lies between them.
    by_radiosity = luminance(np.asarray(renderer.render(scene.changed(gi="radiosity")), float))
    for here in (slice(None), middle):
        assert abs(by_radiosity[here].mean() / by_photons[here].mean() - 1) < 0.12
    dark = scene.changed(curtain=small | {"behind": "blackout"})
    by_radiosity, by_photons = (
        luminance(np.asarray(renderer.render(dark.changed(gi=gi)), float))[middle].mean()
        for gi in ("radiosity", "photons")
    )
    assert by_radiosity < 1.5 * by_photons, "the sheer one does not see what shines on the blackout's back"
    with pytest.raises(InputError, match="curtain: behind Linen plain: has no"):
        renderer.render(scene.changed(curtain=small | {"behind": "linen"}))


def test_a_sun_is_a_disc_far_away(tracer):
    """A floor in its light: cosine times irradiance; under the edge of an awning half of it, a penumbra further none or all."""
    E, wide = np.array([3.0, 2.0, 1.0]), 0.04
    toward = np.array([0.0, 0.8, -0.6])
    lamp = Lamp.of_sun(toward, E, wide)
    down = np.array([[[-50, 1, 0], [50, 1, 0], [50, 1, 50]], [[-50, 1, 0], [50, 1, 50], [-50, 1, 50]]], float)
    ground = np.array([[[-50, 0, -50], [50, 0, 50], [50, 0, -50]], [[-50, 0, -50], [-50, 0, 50], [50, 0, 50]]], float)
    # The edge's shadow is where the sun's middle is seen along it.
    edge = -toward[2] / toward[1]
    seen = {}
    for name, z in (("lit", edge - 0.3), ("edge", edge), ("dark", edge + 0.3)):
        camera = Camera((0.0, 0.5, z), (0.0, 0.0, z), (0.0, 0.0, 1.0), ortho=1e-4)
        shot = Shot(camera, (4, 4), VOILE, Lighting(lamp, DARK, DARK), settings=TraceSettings(spp=64))
        positions = np.concatenate([ground, down])
        seen[name] = tracer.render(positions, np.ones(4, int), np.full((2, 3), 0.5), shot).mean((0, 1))
    np.testing.assert_allclose(seen["lit"], 0.5 / np.pi * 0.8 * E, rtol=2e-3)
    np.testing.assert_allclose(seen["edge"] / seen["lit"], 0.5, atol=0.08)
    assert seen["dark"].max() == 0.0


def test_the_brightest_sun_of_the_map_that_shines_in(renderer):
    radiance = np.full((256, 512, 3), 0.1, np.float32)
    radiance[80:83, 120:123] = [900.0, 800.0, 700.0]
    map_ = Environment.from_array(radiance, name="one sun")
    one = split_suns(radiance)[0]
    (sun,) = one.direction
    turn = np.degrees(np.arctan2(sun[0], sun[2])) - 180.0  # of the map, so that it stands behind the window
    look = {"curtain": {"quads": (72, 18), "pleats": 6, "settle": 0.1}, "size": (8, 8), "sun": "map"}
    show = CurtainShow(renderer.ctx, Scene(env_rotate=-turn, **look), environment=map_)
    lamp = show.shot().lighting.lamp
    place = np.array(lamp.position)
    np.testing.assert_allclose(place / np.linalg.norm(place), [0.0, sun[1], -np.hypot(sun[0], sun[2])], atol=1e-6)
    np.testing.assert_allclose(np.array(lamp.intensity) / (place @ place), one.irradiance[0], rtol=1e-6)
    away = show.shot(Scene(env_rotate=180.0 - turn, **look)).lighting.lamp
    assert max(away.intensity) == 0.0
    show.release()
