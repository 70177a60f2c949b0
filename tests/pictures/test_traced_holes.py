"""Holes of a weave in traced cloth: seen near by, and in the light that falls through; in the mean they are the far cloth."""

import dataclasses

import numpy as np
import pytest

from glcloth.fabric import load_fabric
from glcloth.geometry.camera import Camera
from glcloth.methods.weave_maps import far_footprint, repeat_of
from glcloth.tracing.lamp import Lamp, Lighting
from glcloth.tracing.shot import HangingGrid, Shot, TraceSettings
from glcloth.tracing.threads import shows_threads
from glcloth.tracing.tracer import Tracer

WALL = -0.1


def quad(side, z):
    """Two triangles as passes/accel/gather_grid.comp makes them, rows downward."""
    a, b, c, d = np.array([[-1, 1, z], [1, 1, z], [-1, -1, z], [1, -1, z]]) * [side / 2, side / 2, 1.0]
    return np.array([[a, c, b], [b, c, d]])


@pytest.mark.parametrize(
    ("name", "eye", "lamp"),
    [
        ("lace", 0.05, (0.0, 0.0, 1e3)),
        ("lace", -0.05, (0.0, 0.0, 1e3)),
        ("sheer_voile", 0.05, (300.0, 500.0, 800.0)),
        ("linen_curtain", 0.05, (300.0, 500.0, -800.0)),
    ],
    ids=["through the cloth", "its light on a wall", "threads before the light", "threads behind it"],
)
def test_holes_and_threads_are_the_far_cloth_in_the_mean(ctx, name, eye, lamp):
    fabric = load_fabric(name)
    side = (3.0 if name == "lace" else 12.0) * repeat_of(fabric)[0]
    # A wall that is seen and lit through the same holes would not have the product of the means.
    count = 4 if eye < 0.0 else 2
    positions = np.concatenate([quad(side, 0.0), quad(1.0, WALL)])[:count]
    shot = Shot(
        Camera((0.0, 0.0, eye), (0.0, 0.0, WALL), ortho=side), (128, 128), fabric,
        Lighting(Lamp(lamp, (1e6, 1e6, 1e6)), (0.0, 0.0, 0.0)), settings=TraceSettings(3, accelerator="brute"),
        grid=HangingGrid(0, 1, (side, side), (-side, -side, 0.0), (side, side, 0.0)),
    )  # fmt: skip
    tracer = Tracer(ctx)
    arrays = positions, np.array([0, 0, 1, 1])[:count], np.array([[0.0] * 3, [0.5] * 3])
    try:
        near, far = (tracer.render(*arrays, s)[..., 1] for s in (shot, dataclasses.replace(shot, grid=None)))
        coarse = int(2.0 * side / far_footprint(fabric) / 4.0)
        small = [
            tracer.render(*arrays, dataclasses.replace(s, size=(coarse, coarse)))
            for s in (shot, dataclasses.replace(shot, grid=None))
        ]
    finally:
        tracer.release()
    np.testing.assert_allclose(near.mean(), far.mean(), rtol=0.01)
    assert near.std() > 0.05 * near.mean() and far.std() < 0.02 * far.mean()
    assert np.array_equal(*small)  # no pixel is fine enough


def test_every_piece_of_a_cloth_begins_its_weave_anew(ctx):
    fabric = load_fabric("linen_curtain")
    side = 2.5 * repeat_of(fabric)[0]
    positions = np.concatenate([quad(side, 0.0), quad(side, 0.0) + np.array([3.0 * side, 0.0, 0.0])])
    at, tracer = (3.0 * side, 0.0), Tracer(ctx)
    grid = HangingGrid(0, 1, (side, side), (-side, -side, 0.0), (4.0 * side, side, 0.0), count=2)
    second = Shot(
        Camera((*at, 0.05), (*at, 0.0), ortho=side), (48, 48), fabric,
        Lighting(Lamp((0.0, 0.0, 1e3), (1e6, 1e6, 1e6)), (0.0, 0.0, 0.0)), settings=TraceSettings(2, accelerator="brute"),
        grid=grid,
    )  # fmt: skip
    arrays = positions, np.zeros(4, int), np.zeros((1, 3))
    try:
        whole, alone = (
            tracer.render(*arrays, dataclasses.replace(second, grid=one))
            for one in (grid, dataclasses.replace(grid, first=2, count=0))
        )
    finally:
        tracer.release()
    assert whole[..., 1].std() > 0.05 * whole[..., 1].mean()
    assert np.array_equal(whole, alone)


def test_each_fabric_of_a_scene_shows_its_own_threads_and_holes(ctx):
    """Four side by side before a wall, with maps of two sizes, colours, fewer tangents, no weave: each as it is alone."""
    through = load_fabric("lace").transmission
    linen = load_fabric("linen_curtain")
    fabrics = [
        *(load_fabric(name).changed(transmission=through) for name in ("herringbone_tweed", "houndstooth")),
        load_fabric("blackout"), linen,
    ]  # fmt: skip
    side = 12.0 * repeat_of(linen)[0]
    strips = [quad(side, 0.0) + np.array([(k - 1.5) * side, 0.0, 0.0]) for k in range(4)]
    flat = [(1.3 * side, 1.2 * side), (1.1 * side, 0.93 * side), (side, side), (side, side)]  # the first ones in folds
    grids = [HangingGrid(2 * k, 1, flat[k], (-side,) * 3, (side,) * 3) for k in range(4)]
    several = Shot(
        Camera((0.0, 0.0, 0.05), (0.0, 0.0, WALL), ortho=side), (256, 64), fabrics[0],
        Lighting(Lamp((0.0, 0.0, 1e3), (1e6, 1e6, 1e6)), (0.0, 0.0, 0.0)), settings=TraceSettings(3, accelerator="brute"),
        grid=grids[0], others=tuple((2 * k, fabrics[k]) for k in (1, 2, 3)), other_grids=tuple(grids[1:]),
    )  # fmt: skip
    tracer = Tracer(ctx)

    def trace(shot, *cloth, wall=True):
        positions = np.concatenate([*cloth, quad(1.0, WALL)])[: None if wall else -2]
        material = np.minimum(np.arange(len(positions)) // (2 * len(cloth)), 1)
        return tracer.render(positions, material, np.array([[0.0] * 3, [0.5] * 3]), shot)

    def alone(k, shot=several):
        x = (k - 1.5) * side
        camera = Camera((x, 0.0, 0.05), (x, 0.0, WALL), ortho=side)
        grid = shot.grid and dataclasses.replace(grids[k], first=0)
        return dataclasses.replace(
            shot, camera=camera, size=(64, 64), fabric=fabrics[k], grid=grid, others=(), other_grids=()
        )

    try:
        together = trace(several, *strips)
        for k in range(4):
            got, expected = together[:, 64 * k : 64 * (k + 1)], trace(alone(k), strips[k])
            # A ray on the line between two strips meets either.
            np.testing.assert_allclose(got[:, 1:-1], expected[:, 1:-1], rtol=2e-3, atol=1e-4 * expected.mean())
        lit = Lighting(Lamp((300.0, 500.0, 800.0), (1e6, 1e6, 1e6)), (0.0, 0.0, 0.0))
        near = trace(dataclasses.replace(several, lighting=lit), *strips, wall=False)[:, 192:, 1]
        far = trace(alone(3, dataclasses.replace(several, lighting=lit, grid=None)), strips[3], wall=False)[..., 1]
    finally:
        tracer.release()
    np.testing.assert_allclose(near.mean(), far.mean(), rtol=0.01)
    assert near.std() > 0.05 * near.mean() and far.std() < 0.02 * far.mean()


def test_threads_show_from_either_side_of_the_cloth():
    """By the distance of the box that it hangs in, wherever the eye is."""
    fabric = load_fabric("linen_curtain")
    grid, size = HangingGrid(0, 4, (0.1, 0.1), (-1.0, 0.0, -0.1), (1.0, 2.0, 0.1)), (64, 48)
    near = far_footprint(fabric) / (2.0 * np.tan(np.radians(17.5)) / 48)
    for way in ((0, 0, 1), (0, 0, -1), (1, 0, 0), (-1, 0, 0), (0, -1, 0)):
        face = np.array([0.0, 1.0, 0.0]) + np.array(way) * (1.0, 1.0, 0.1)
        for share, shows in ((0.9, True), (1.1, False)):
            eye = face + share * near * np.array(way)
            camera = Camera(tuple(eye), (0.0, 1.0, 0.0), (0.3, 0.5, 0.2))
            assert shows_threads(Shot(camera, size, fabric), fabric, grid) is shows
