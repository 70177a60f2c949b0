"""Method `path` in the curtain's room, and its denoiser: closed forms, the other tracer, and two ways to draw the sky."""

import dataclasses
import sys
from types import SimpleNamespace

import numpy as np
import pytest

import glcloth
from glcloth.color import luminance
from glcloth.curtain.paths import CurtainPaths, faceted, portals_of, rectangles_about
from glcloth.curtain.show import CurtainShow
from glcloth.errors import InputError
from glcloth.fabric import load_fabric
from glcloth.geometry.camera import Camera
from glcloth.gpu.buffers import TextureBuffer
from glcloth.gpu.environment_map import EnvironmentMap
from glcloth.light.environment import Environment
from glcloth.scene import Scene
from glcloth.tracing.denoise import denoised
from glcloth.tracing.energy import mean_albedo, reflection_limit
from glcloth.tracing.lamp import Lamp
from glcloth.tracing.path import PathSums, PathTracer, PathView
from glcloth.tracing.path_world import PathWorld
from glcloth.twins.sheet import R_limited, R_sheet, T_open, T_sheet

DARK = Environment.from_array(np.full((8, 16, 3), 1e-9), name="dark")
WHITE = Environment.from_array(np.ones((16, 32, 3)), name="white")
SQUARE = np.array([[[-1.0, -1, 0], [1, -1, 0], [1, 1, 0]], [[-1, -1, 0], [1, 1, 0], [-1, 1, 0]]], np.float32)
FAR = faceted(SQUARE + np.float32([40, 0, 0]))


def traced(ctx, world, camera, environment, size=(16, 12), samples=64, **view):
    """The sums of a picture of a world under a map."""
    tracer, texture = PathTracer(ctx), EnvironmentMap(ctx)
    tracer.take(world)
    tracer.sky.take_map(environment, np.eye(3), suns=False)
    behind = {"environment_map": texture.texture(environment), "map_from_world": np.eye(3)}
    for _ in tracer.steps(PathView(camera, size, behind, **view), samples):
        pass
    sums = tracer.sums()
    tracer.release()
    texture.release()
    return sums


def hung(renderer, fabric="sheer_voile", **changes):
    """The curtain in its room, which has hardly settled."""
    scene = Scene(curtain={"settle": 0.02}, fabric=fabric, method="path", size=(20, 20), **changes)
    return CurtainShow(renderer.ctx, scene)


def test_a_lamp_on_a_wall_is_exact(renderer):
    lamp = Lamp((0.3, -0.2, 0.8), (3.0, 2.0, 1.0))
    world = PathWorld(((FAR, load_fabric("linen")),), ((faceted(SQUARE), np.full((2, 3), 0.5)),))
    camera = Camera((0.0, 0.0, 2.0), (0.0, 0.0, 0.0), ortho=0.02)
    sums = traced(renderer.ctx, world, camera, DARK, samples=2, lamp=lamp)
    d = np.array(lamp.position)
    expected = 0.5 / np.pi * np.array(lamp.intensity) * d[2] / (d @ d) ** 1.5
    np.testing.assert_allclose(sums.picture[..., :3].mean((0, 1)), expected, rtol=2e-3)
    # Rays start close to a wall of two triangles: what stands a millimetre before it hides the lamp.
    shade = faceted((0.5 * SQUARE + np.float32([0, 0, 1e-3])).astype("f4"))
    behind = PathWorld(world.cloths, (*world.solids, (shade, np.full((2, 3), 0.5))))
    camera = Camera((0.0, 0.0, 5e-4), (0.0, 0.0, 0.0), fov_deg=30.0)
    assert traced(renderer.ctx, behind, camera, DARK, samples=1, lamp=lamp).picture[..., :3].max() < 1e-6


def test_needles_of_sheer_cloth_dim_light_once(renderer, monkeypatch):
    """A hierarchy holds them in several leaves; a lamp shines through three cones of them on the floor."""
    angle = 2.0 * np.pi * np.arange(1000) / 1000
    rim = np.stack([np.cos(angle), np.sin(angle), 0.1 + 0.05 * np.sin(5 * angle)], -1)
    apex = np.broadcast_to([0.0, 0.0, 1.0], rim.shape)
    cone = np.stack([apex, rim, np.roll(rim, -1, 0)], 1)
    fan = faceted(np.concatenate([cone, 0.99 * cone, 0.98 * cone]).astype(np.float32))
    world = PathWorld(((fan, load_fabric("sheer_voile")),), ((faceted(2 * SQUARE), np.full((2, 3), 0.5)),))
    camera, lamp = Camera((0.5, 0.3, 0.05), (0.0, 0.0, 0.0), fov_deg=40.0), Lamp((0.5, -0.4, 3.0), (5.0, 5.0, 5.0))
    means = []
    for most in (1.0, 1e9):
        monkeypatch.setattr("glcloth.accel.needles.MOST_BOXES", most)
        means.append(
            traced(renderer.ctx, world, camera, DARK, samples=2, lamp=lamp, vertices=1).picture[..., :3].mean()
        )
    assert means[0] == pytest.approx(means[1], rel=1e-4) and means[1] > 0.005


@pytest.mark.parametrize("name", ["sheer_voile"])
def test_lobes_that_are_drawn_keep_the_energy(renderer, name):
    fabric = load_fabric(name)
    t, tau = fabric.transmission, np.array(fabric.transmission.tau)
    omega = np.array([np.sin(0.4), 0.0, np.cos(0.4)])
    camera = Camera(tuple(3 * omega), (0.0, 0.0, 0.0), ortho=0.1)
    world = PathWorld(((faceted(SQUARE), fabric),))
    sums = traced(renderer.ctx, world, camera, WHITE, samples=160, spread=True)
    limit, passed = reflection_limit(fabric), T_sheet(omega, t.k_a, t.k_t, tau, t.rho)
    R = R_limited(R_sheet(omega, t.k_t, t.rho, t.eta_1, t.eta_2), passed, limit * mean_albedo(fabric))
    from test_path import albedo_of

    expected = passed + R + limit * albedo_of(fabric, omega)
    error = np.sqrt((sums.standard_error**2).sum()) / sums.squares.size
    np.testing.assert_allclose(sums.picture[..., :3].mean((0, 1)), expected, atol=4 * error + 0.01)
    # What is seen of the map itself is what the holes show.
    hidden = traced(renderer.ctx, world, camera, WHITE, samples=160, spread=True, background=False)
    straight = (expected - hidden.picture[..., :3].mean((0, 1))).mean()
    assert abs(straight - t.k_a * T_open(omega, t.rho)) < 0.02


def test_direct_light_is_that_of_the_other_tracer(renderer):
    fabric = load_fabric("sheer_voile")
    # Hardly a mirror, and nothing even: what is left is the lamp, once, through and on the cloth.
    t = fabric.transmission.changed(eta_1=1.0, eta_2=1.02)
    show = hung(renderer, fabric.changed(transmission=t), spp=96)
    show.environment = DARK
    sums = show.path_sums(vertices=1)
    show.build()
    nothing, none = TextureBuffer(renderer.ctx, np.zeros((64, 4), "f4")), np.zeros(len(show.room.positions), np.uint32)
    shot = show.shot()
    shot = dataclasses.replace(
        shot, lighting=dataclasses.replace(shot.lighting, ambient=(0.0, 0.0, 0.0)),
        settings=dataclasses.replace(shot.settings, depth=8, spp=16, cutoff=1e-4),
        indirect=dict(
            chart_of=TextureBuffer(renderer.ctx, none, "r32ui"), chart_data=nothing, light_texels=nothing, sheet_texels=0,
            sheet_place=(0.0, 0.0, 1.0, 1.0), sheet_cells=(1, 1), sheet_azimuth=1.0,
        ),
    )  # fmt: skip
    other = luminance(show.tracer.trace(shot).astype(float))
    own = luminance(sums.picture[..., :3].astype(float))
    error = np.sqrt((sums.standard_error**2).mean()) / 20
    assert error < 0.015 * other.mean()
    assert abs(own.mean() - other.mean()) < 4 * error + 0.01 * other.mean()
    # And where it is: curtain above, floor and table below.
    for rows in (slice(0, 10), slice(10, 20)):
        assert abs(own[rows].mean() / other[rows].mean() - 1) < 0.05
    show.release()


def test_the_sky_through_the_window_is_the_sky(renderer):
    """Drawn by points of the openings or by directions of the map, it sends the same light."""
    show = hung(renderer, lamp_intensity=(0.0, 0.0, 0.0))
    portals = portals_of(renderer.ctx, show.room)
    assert len(portals) == 1
    low, high = portals[0, 0], portals[0].sum(0)
    assert (low[:2] <= (-1.1, 0.4)).all() and (high[:2] >= (1.1, 2.35)).all() and low[2] == pytest.approx(-0.14)
    found = []
    for rectangles in (portals, portals[:0]):
        paths = CurtainPaths(renderer.ctx, show.room)
        paths._portals = rectangles
        for _ in paths.steps(show.simulation.meshes(), show.shot(), 64, vertices=3):
            pass
        sums = paths.tracer.sums()
        hit = np.arange(20)[:, None] >= np.full(20, 15)  # floor and table
        Y = luminance(sums.picture[..., :3].astype(float))
        found.append((Y[hit].mean(), np.sqrt((sums.standard_error[hit].astype(float) ** 2).sum()) / hit.sum()))
        paths.release()
    (a, sa), (b, sb) = found
    assert sa < 0.8 * sb and sb < 0.05 * b
    assert abs(a - b) < 4 * np.hypot(sa, sb)
    show.release()


def test_cells_of_one_plane_become_one_rectangle():
    cell = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    turned = np.roll(cell, 1, 1) + np.array([5.0, 0, 0])
    found = rectangles_about(np.stack([cell, cell + np.array([2.0, 3, 0]), turned]))
    np.testing.assert_array_equal(found[1], [[0, 0, 0], [3, 0, 0], [0, 4, 0]])
    np.testing.assert_array_equal(found[0], [[5, 0, 0], [0, 1, 0], [0, 0, 1]])


def test_the_renderer_traces_the_curtain_by_paths(renderer):
    look = dict(method="path", size=(16, 12), frame=0)
    scene = Scene(curtain={"settle": 0.0, "quads": (24, 12), "pleats": 4}, **look)
    picture = renderer.render(scene, spp=3)
    assert picture.shape == (12, 16, 3) and np.isfinite(picture).all() and np.asarray(picture).max() > 0.1
    assert renderer.path_sums().samples == 3
    assert renderer.facts()["method"] == "path" and renderer.facts()["samples"] == 3
    assert "noise" in scene.model_dump()
    renderer.render(scene, noise=60.0)
    assert renderer.path_sums().noise <= 60.0
    with pytest.raises(InputError, match="expected trace or path"):
        renderer.render(scene, method="direct")


def test_a_denoiser_is_told_of_edges_and_of_the_background(monkeypatch):
    """Of two samples one pixel is covered by one: its alpha is denoised, too, and what is not covered has an albedo of 1."""
    told = []

    def denoise(color, albedo, normal, hdr=False):
        told.append((color, albedo, normal, hdr))
        return 0.5 * color

    monkeypatch.setattr("importlib.util.find_spec", lambda name: name)
    monkeypatch.setitem(sys.modules, "pyoidn", SimpleNamespace(denoise=denoise))
    albedo = np.full((1, 3, 3), 0.2, np.float32) * np.array([0.0, 1.0, 2.0], np.float32)[None, :, None]
    light, cover = np.full((1, 3, 3), 4.0, np.float32), np.array([[0.0, 1.0, 2.0]], np.float32)
    clean = denoised(PathSums(2, light, light[..., 0], light[..., 0], np.zeros((1, 3, 3), np.float32), albedo, cover))
    (_, first, _, hdr), (alpha, second, _, _) = told
    np.testing.assert_allclose(first[0, :, 0], [1.0, 0.6, 0.2], rtol=1e-6)
    np.testing.assert_array_equal(first, second)
    assert hdr and clean.shape == (1, 3, 4)
    np.testing.assert_allclose(alpha[0, :, 0], [0.0, 0.5, 1.0])
    np.testing.assert_allclose(clean[0, :, :3], 1.0)
    np.testing.assert_allclose(clean[0, :, 3], [0.0, 0.25, 0.5])
    whole = denoised(
        PathSums(2, light, light[..., 0], light[..., 0], np.zeros((1, 3, 3), np.float32), albedo, 2.0 * (cover > 0))
    )
    np.testing.assert_array_equal(whole[0, :, 3], [0.0, 1.0, 1.0])  # no edge: as it was


def test_denoised_pictures_are_nearer_to_the_truth(renderer, monkeypatch):
    look = dict(mesh="drape", fabric="linen", method="path", size=(48, 36), env="sky", background=False)
    truth = np.asarray(renderer.render(spp=192, **look), float)
    sums_picture = np.asarray(renderer.render(spp=4, **look), float)
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    with pytest.raises(InputError, match=r"pip install 'glcloth\[denoise\]'"):
        renderer.render(spp=4, denoise=True, **look)
    monkeypatch.undo()
    pytest.importorskip("pyoidn")
    clean = np.asarray(renderer.render(spp=4, denoise=True, **look), float)
    assert clean.shape == truth.shape
    error = lambda p: np.abs(p - truth)[..., :3].mean()  # noqa: E731
    assert error(clean) < 0.7 * error(sums_picture)
    assert abs(clean[..., :3].mean() / truth[..., :3].mean() - 1) < 0.05
    # Alpha as well: nearer to the truth at outlines (6 % by root mean square, where four samples say), whole within.
    alpha = lambda p: (p - truth)[..., 3]  # noqa: E731
    assert np.square(alpha(clean)).mean() < np.square(alpha(sums_picture)).mean()
    assert np.abs(alpha(clean)).mean() < 0.02 and np.abs(alpha(clean))[truth[..., 3] > 0.999].max() < 0.05
    np.testing.assert_array_equal(clean, denoised(renderer.path_sums()))
    assert glcloth.Scene(denoise=True).denoise
