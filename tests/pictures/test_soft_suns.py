"""Suns are discs: penumbrae against the area of a disc, coarse cloth's shadows against fine cloth's."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from glcloth.color import luminance
from glcloth.fabric import load_fabric
from glcloth.geometry import shapes
from glcloth.geometry.camera import Camera
from glcloth.geometry.mesh import build_mesh
from glcloth.light.lights import Lights, SphericalGaussians, Suns
from glcloth.picture import stage
from glcloth.twins.cloth import f_cloth
from glcloth.twins.sun_disc import disc_directions

NO_LIGHT = SphericalGaussians([], [], [])
TOWARD = np.array([-1.0, 0.0, 1.0]) / np.sqrt(2.0)
ABOVE = Camera((0.45, 0.0, 5.0), (0.45, 0.0, 0.0), ortho=0.8)
WIDE = Camera((0.0, 0.0, 5.0), (0.0, 0.0, 0.0), ortho=2.0)
SIZE = 64, 48


def sun(radius_deg):
    return Lights(NO_LIGHT, Suns([TOWARD], [[3.0, 3.0, 3.0]], np.radians(radius_deg)))


def over_a_floor(*others, floor=4):
    """A floor of 3 x 3 m, and cloth over it, each (positions, triangles), as one mesh."""
    positions, triangles, _, _ = shapes.plane(3.0, floor)
    parts, corners = [positions], [triangles]
    for more, its in others:
        corners.append(its + sum(map(len, parts)))
        parts.append(more)
    return build_mesh("floor", np.concatenate(parts), np.concatenate(corners), None)


def half_plane(height):
    """Cloth over x < 0, at a height, that the camera above looks past."""
    positions, triangles, _, _ = shapes.plane(6.0, 8)
    return positions + np.array([-3.0, 0.0, height]), triangles


def seen_share(renderer, mesh, lights, **look):
    """What share of a sun the pixels see."""
    look = {"fabric": "linen", "camera": ABOVE, "size": SIZE, "background": False} | look
    lit, shaded = (
        renderer.render(mesh=mesh, lights=lights, shadows=shadows, **look)[..., :3].mean(-1)
        for shadows in ("off", "sun")
    )
    return shaded / np.maximum(lit, 1e-9), lit > 1e-3


@pytest.mark.parametrize("radius_deg", [0.0, 4.0])
@pytest.mark.parametrize("method", ["direct", "reference"])
def test_a_penumbra_is_the_part_of_the_disc_that_an_edge_leaves(renderer, method, radius_deg):
    """The edge's shadow falls where x is its height; a pixel there sees that part of the disc which a line cuts off."""
    height = 0.5
    mesh = over_a_floor(half_plane(height), floor=60)  # rays start a fiftieth of a triangle above it
    seen, _ = seen_share(renderer, mesh, sun(radius_deg), method=method, cube=4)
    x = 0.45 + (np.arange(SIZE[0]) + 0.5 - SIZE[0] / 2) * 0.8 / SIZE[1]
    floor = x > 0.05
    angle = np.arctan2(height, -x) - np.pi * 0.75  # from the edge to the sun's middle, about the edge's direction
    s = np.clip(angle / np.radians(max(radius_deg, 1e-3)), -1.0, 1.0)
    expected = 0.5 + (s * np.sqrt(1.0 - s * s) + np.arcsin(s)) / np.pi
    error = np.abs(seen[:, floor] - expected[floor])
    soft = (expected > 0.02) & (expected < 0.98) & floor
    assert soft.sum() >= (5 if radius_deg else 0)
    assert error.mean() < 0.01 and error[:, ~soft[floor]].max() < 0.02
    if radius_deg:
        # Sixteen points are off by what one or two of them are worth, and not to one side; the reference weighs its 64 by what
        # the fabric reflects of each.
        assert np.abs(seen[:, soft].mean(0) - expected[soft]).max() < (0.025 if method == "direct" else 0.05)
        assert seen[:, soft].std(0).max() < 0.06


def drum(segments, height=0.55):
    """A tube of cloth along y over the floor."""
    turn = np.arange(segments) * 2 * np.pi / segments
    rows = np.linspace(-1.2, 1.2, max(segments // 2, 4))
    positions = np.array([[0.35 * np.cos(t) - 0.55, y, 0.35 * np.sin(t) + height] for y in rows for t in turn])
    at = np.arange(len(rows) - 1)[:, None] * segments + np.arange(segments)
    beside = np.arange(len(rows) - 1)[:, None] * segments + (np.arange(segments) + 1) % segments
    quads = np.stack([at, beside, beside + segments, at + segments], -1).reshape(-1, 4)
    return positions, np.concatenate([quads[:, :3], quads[:, [0, 2, 3]]])


def test_shadows_of_coarse_cloth_are_those_of_fine_cloth(renderer, monkeypatch):
    """A tube of 14 sides hides the sun as one of 120 does, on the floor and on itself, but for an eighth of the error."""
    tilted = np.array([-1.0, 0.35, 1.0]) / np.linalg.norm([-1.0, 0.35, 1.0])
    lights = Lights(NO_LIGHT, Suns([tilted], [[3.0, 3.0, 3.0]]))
    truth, lit = seen_share(renderer, over_a_floor(drum(120)), lights, camera=WIDE)
    error = {}
    for cut in (0, 2):
        monkeypatch.setattr(stage, "cuts", lambda *_, cut=cut: cut)
        mesh = over_a_floor(drum(14))
        seen, there = seen_share(renderer, mesh, lights, camera=WIDE)
        error[cut] = np.abs(seen - truth)[lit & there].mean()
    assert error[0] > 0.004 and error[2] < 0.3 * error[0]


def test_sheer_cloth_that_is_cut_lets_as_much_through(renderer, monkeypatch):
    """A hit on a part is one on its triangle: of flat sheets nothing changes, whatever the part and the yarns' direction."""
    mesh = over_a_floor(half_plane(0.5))
    pictures = []
    for cut in (0, 2):
        monkeypatch.setattr(stage, "cuts", lambda *_, cut=cut: cut)
        look = dict(mesh=replace_mesh(mesh), lights=sun(0.0), fabric=load_fabric("linen_curtain"), shadows="sun")
        pictures.append(renderer.render(camera=ABOVE, size=(32, 24), background=False, **look)[..., :3])
    assert pictures[0][12, 6:12].min() > 0.0 and pictures[0][12, -1].mean() > 1.3 * pictures[0][12, 6].mean()
    assert np.mean(np.abs(pictures[1] - pictures[0]) > 0.01 * pictures[0].mean()) < 0.02


def replace_mesh(mesh):
    """The same mesh as another object, so that nothing is kept of it."""
    return replace(mesh, name=mesh.name)


def test_cuts_are_as_many_as_the_coarsest_cloth_wants():
    fine, even, coarse = (SimpleNamespace(mean_edge=edge, radius=1.0) for edge in (0.003, 0.01, 0.05))
    assert [stage.cuts([mesh], 1000, 0) for mesh in (fine, even, coarse)] == [0, 1, 2]
    assert stage.cuts([fine, coarse], 1000, 0) == 2
    assert stage.cuts([coarse], 50_000, 1000) == 1 and stage.cuts([coarse], 200_000, 0) == 0


def test_six_wide_suns_through_sheer_folds_are_the_sum_of_each(renderer):
    """A pixel sends each of them 16 rays through up to eight sheets: together more than llvmpipe's loops have rounds."""
    rng = np.random.default_rng(1)
    toward = np.abs(rng.normal(size=(6, 3))) + np.array([0.0, 0.5, 0.0])
    look = {"mesh": "drape", "fabric": "sheer_voile", "size": (32, 24), "shadows": "sun", "background": False}

    def lit(number):
        suns = Suns(toward[number], np.full((len(toward[number]), 3), 1.5), np.radians(5.0))
        return renderer.render(lights=Lights(NO_LIGHT, suns), **look)[..., :3].astype(float)

    whole, each = lit(slice(None)), sum(lit([number]) for number in range(6))
    np.testing.assert_allclose(whole, each, atol=1e-5 * whole.max())


@pytest.mark.parametrize(
    ("method", "name", "bound"),
    [("direct", "velvet", 0.04), ("direct", "linen", 0.08), ("reference", "velvet", 0.04), ("paper", "linen", 0.02)],
)
def test_the_horizon_cuts_the_disc(renderer, method, name, bound):
    """Cloth that a disc lights from its horizon, up or down; a point in its middle is 15 % off for velvet, 45 for linen."""
    rng, fabric = np.random.default_rng(3), load_fabric(name)
    got, expected = [], []
    for height in np.repeat([-0.6, 0.0, 0.4, 0.8], 6):
        azimuth, z, turn = rng.uniform(0, 2 * np.pi), rng.uniform(0.2, 0.9), rng.normal(np.pi, 0.5)
        sun = np.array([np.cos(azimuth), np.sin(azimuth), np.sin(np.radians(1.5 * height))])
        view = np.sqrt(1 - z * z) * np.array([np.cos(azimuth + turn), np.sin(azimuth + turn), 0]) + [0, 0, z]
        lights = Lights(NO_LIGHT, Suns([sun], [[1.0, 1.0, 1.0]], np.radians(1.5)))
        disc = disc_directions(sun / np.linalg.norm(sun), np.radians(1.5), 1500)
        expected.append(luminance(f_cloth(disc[disc[:, 2] > 0], view, *fabric.arrays()).sum(0) / 1500))
        got.append(luminance(renderer.radiance(fabric, view, lights, method=method).astype(float))[0])
    error = np.abs(np.array(got) - expected).mean() / np.mean(expected)
    assert error < bound, f"{error:.1%}"
