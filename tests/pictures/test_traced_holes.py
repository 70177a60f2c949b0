"""Holes of a weave in traced cloth: seen near by, and in the light that falls through; in the mean they are the far cloth."""

import dataclasses

import numpy as np
import pytest

from glcloth.fabric import load_fabric
from glcloth.geometry.camera import Camera
from glcloth.methods.weave_maps import far_footprint, repeat_of
from glcloth.tracing.lamp import Lamp, Lighting
from glcloth.tracing.shot import HangingGrid, Shot, TraceSettings
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
